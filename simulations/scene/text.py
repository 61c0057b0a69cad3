"""Scenes as text: TOML to flat keys, and values back to TOML or into a table. What they mean is checked elsewhere."""

import json
import re
import tomllib
from collections.abc import Iterable
from math import isfinite
from pathlib import Path
from typing import Any

from .errors import SceneError, one_line, shown

LARGEST_FILE = 10_000_000  # bytes of a file
NUMBER = r"[-+]?(?:\d+\.?\d*|\.\d+)(?:[eE][-+]?\d+)?"  # .5 and 1. too, which TOML does not know


def read_text(path: Path, what: str) -> str:
    """Text of a file; SceneError, which calls it ``what``, where it cannot be read."""
    try:
        if path.exists() and not path.is_dir() and not (path.is_file() and path.stat().st_size <= LARGEST_FILE):
            raise SceneError(f"{what} {shown(path)} cannot be read: not a text file of at most {LARGEST_FILE} bytes")
        return path.read_text(encoding="utf-8-sig")
    except UnicodeDecodeError:
        raise SceneError(f"{what} {shown(path)} cannot be read: it is not text in UTF-8") from None
    except (OSError, ValueError) as error:
        raise SceneError(f"{what} {shown(path)} cannot be read: {getattr(error, 'strerror', error)}") from None


def read_keys(text: str, name: str = "the scene") -> dict[str, Any]:
    """The flat keys of a TOML text as they are written, unchecked. name: what a SceneError calls the text."""
    try:
        return flatten(tomllib.loads(text))
    except SceneError:
        raise
    except (ValueError, RecursionError) as error:  # too long a number, too deep a list
        raise SceneError(f"{name} is not TOML: {one_line(str(error))}{_quoted(text, str(error))}") from None


def _quoted(text: str, message: str) -> str:
    """The line at which reading a TOML text ended, as the end of the message; "" where the message names no place."""
    place = re.search(r"\(at (?:line (\d+), column \d+|end of document)\)$", message)
    if not place:
        return ""
    line = text.split("\n")[int(place[1]) - 1] if place[1] else text.rstrip().split("\n")[-1]
    return f": {shown(line.strip())}"


def read_value(text: str):
    """A value as TOML reads it, or a number as most programs write it; any other bare word is a text."""
    try:
        document = tomllib.loads(f"value = {text}")
    except (ValueError, RecursionError):
        return float(text) if re.fullmatch(NUMBER, text) else text
    return document["value"] if len(document) == 1 else text


def flatten(document: dict) -> dict[str, Any]:
    """``{"solid": {"k": 0.3}}`` as ``{"solid.k": 0.3}``."""
    flat: dict[str, Any] = {}
    for name, value in document.items():
        entries = (
            {f"{name}.{inner}": v for inner, v in value.items()} if isinstance(value, dict) else {str(name): value}
        )
        for key, inner in entries.items():
            if key in flat:
                raise SceneError(f"{one_line(key)} = {shown(inner)} is given twice")
            flat[key] = inner
    return flat


def written(value) -> str:
    """A value as TOML: JSON but for two characters, and for what is no number."""
    if isinstance(value, (list, tuple)):
        return f"[{', '.join(map(written, value))}]"
    if isinstance(value, float) and not isfinite(value):
        return str(value)
    return json.dumps(value, ensure_ascii=False).replace("\x7f", "\\u007f")


def table_row(cells: Iterable[str]) -> str:
    """A row of a Markdown table, whose cells may hold a |."""
    return f"| {' | '.join(cell.replace('|', chr(92) + '|') for cell in cells)} |"
