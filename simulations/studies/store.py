"""Finished runs on disk, one line of JSON each: what a stopped study leaves behind is what the next one begins with."""

import json
import os
from contextlib import suppress
from pathlib import Path
from typing import Any

START = '{"key": '  # of every line


class Store:
    """A file of lines {"key", "values", "row"}. One process writes; a line cut short by a stop is passed over."""

    def __init__(self, path: Path):
        self.path = path

    def is_own(self) -> bool:
        """Whether ``keep`` wrote a line of it, or the beginning of one; also where there is no file.

        Another line in it does not count.
        """
        lines = self._lines()
        return any(line.startswith(START) for line in lines) or all(START.startswith(line) for line in lines)

    def read(self) -> dict[str, dict[str, Any]]:
        """Every finished row by key."""
        return {record["key"]: record["row"] for record in self._records()}

    def _lines(self) -> list[str]:
        """Without the zeros that a power cut may leave behind what was written, or in its place."""
        text = self.path.read_text(encoding="utf-8", errors="replace") if self.path.exists() else ""
        return text.replace("\0", "").splitlines()

    def _records(self):
        for line in self._lines():
            with suppress(ValueError, KeyError, TypeError):
                record = json.loads(line)
                yield {name: record[name] for name in ("key", "values", "row")}

    def values(self) -> list[dict[str, Any]]:
        """The values of every finished run."""
        return [record["values"] for record in self._records()]

    def keep(self, key: str, values: dict[str, Any], row: dict[str, Any]):
        """Append one run, on disk before this returns. OSError where it cannot be."""
        line = json.dumps({"key": key, "values": values, "row": row})
        with self.path.open("a+b") as file:
            if file.tell() > 0:
                file.seek(-1, os.SEEK_END)
                if file.read(1) != b"\n":  # a line cut short must not swallow this one
                    file.write(b"\n")
            file.write(line.encode() + b"\n")
            file.flush()
            os.fsync(file.fileno())
