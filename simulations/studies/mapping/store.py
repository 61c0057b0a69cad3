"""Finished loops on disk, one line each: what an interrupted map leaves behind is what the next run begins with."""

import json
import os
from pathlib import Path

from .points import Energies, Point


class Store:
    """loops-RANK.jsonl in a folder. Each rank appends to its own file; all of them are read, whatever wrote them."""

    def __init__(self, folder: Path, rank: int):
        self.folder, self._path = folder, folder / f"loops-{rank}.jsonl"

    def read(self) -> dict[Point, Energies]:
        """Every loop kept so far; a line cut short by an interruption is left out."""
        found = {}
        for path in sorted(self.folder.glob("loops-*.jsonl")):
            for line in path.read_text(encoding="utf-8").splitlines():
                try:
                    record = json.loads(line)
                    found[Point(**record["point"])] = Energies(**record["result"])
                except (ValueError, KeyError, TypeError):
                    continue
        return found

    def keep(self, point: Point, result: Energies):
        """Append one loop, on disk before this returns."""
        record = {"point": point.as_dict(), "result": vars(result)}
        begun = self._path.exists() and self._path.stat().st_size > 0
        with self._path.open("a+b") as file:
            if begun:  # a line cut short must not swallow this one
                file.seek(-1, os.SEEK_END)
                if file.read(1) != b"\n":
                    file.write(b"\n")
            file.write(json.dumps(record).encode() + b"\n")
            file.flush()
            os.fsync(file.fileno())
