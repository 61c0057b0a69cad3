"""Variations of a sweep: keys with lists or ranges of values, and tables of keys, as a list of changes of a scene."""

import csv
import io
import itertools
import re
from collections.abc import Iterable, Mapping, Sequence
from math import inf
from pathlib import Path
from typing import Any

import numpy as np

from ..scene import Scene, SceneError, parse, shown
from ..scene.errors import one_line
from ..scene.reading import text_of
from ..scene.text import NUMBER, flatten, read_keys, read_text, read_value, written

Changes = dict[str, Any]  # keys of a scene and their values
MOST = 100_000  # scenes of a sweep
STATUS, REASON = "status", "reason"  # columns of a sweep's table beside its keys and results
RESULTS = ("a[m]", "indentation[m]", "peak_pressure[Pa]", "reference", "checks")  # columns of every scene's results
RESULTS += ("unknowns", "increments", "newton_iterations", "seconds")
RANGE = re.compile(rf"({NUMBER}):({NUMBER}):(\d{{1,9}})")
TOKEN = re.compile(r'''(?<!\w)(?:"(?:\\.|[^"\\])*"|'[^']*')|.''', re.DOTALL)  # a text in quotes, or one character


def read_vary(options: Sequence[str]) -> dict[str, list]:
    """Values by key of ``KEY=FIRST:LAST:COUNT`` and ``KEY=VALUE,VALUE,...``."""
    vary: dict[str, list] = {}
    for option in options:
        key, equals, text = (part.strip() for part in option.partition("="))
        if not (key and equals and text):
            raise SceneError(f"--vary {shown(option)} is not allowed: KEY=FIRST:LAST:COUNT or KEY=VALUE,VALUE,...")
        if key in vary:
            raise SceneError(f"--vary {key} is given twice")
        vary[key] = _values(key, text)
    return vary


def _values(key: str, text: str) -> list:
    found = RANGE.fullmatch(text)
    if found:
        first, last, count = float(found[1]), float(found[2]), int(found[3])
        if not (2 <= count <= MOST and 0 < abs(last - first) < inf):
            raise SceneError(f"--vary {key}={text} is not allowed: two different ends and 2 to {MOST} values")
        return [float(f"{value:.12g}") for value in np.linspace(first, last, count)]
    if ":" in text and "[" not in text and '"' not in text:
        allowed = f"a range is FIRST:LAST:COUNT, COUNT from 2 to {MOST}"
        raise SceneError(f"--vary {key}={shown(text)} is not allowed: {allowed}")
    values = read_value(f"[{text}]")
    if isinstance(values, list):
        return values
    values = [read_value(part.strip()) for part in _parts(text)]
    if "" in values:
        raise SceneError(f"--vary {key}={shown(text)} is not allowed: a value is missing between two commas")
    return values


def _parts(text: str) -> list[str]:
    """``text`` split at the commas outside quotes and brackets."""
    parts, depth = [""], 0
    for token in TOKEN.findall(text):
        depth += (token in ("[", "{")) - (token in ("]", "}"))
        if token == "," and depth < 1:
            parts.append("")
        else:
            parts[-1] += token
    return parts


def read_table(path: Path) -> list[Changes]:
    """Rows of a CSV file whose columns are keys of the scene."""
    table = io.StringIO(read_text(path, "--csv-in"))
    try:
        head, *lines = list(csv.reader(table, skipinitialspace=True)) or [[]]
    except csv.Error as error:  # a quote that is never closed makes one cell of the rest
        raise SceneError(f"--csv-in {shown(path)} is not a table: {error}") from None
    names = [name.strip() for name in head]
    for mark, word in ((";", ";"), ("\t", "tabs")):
        if len(names) == 1 and mark in names[0]:
            raise SceneError(f"--csv-in {shown(path)} is not allowed: its columns are separated by {word}, not by ,")
    if not any(lines) or "" in names or len(set(names)) < len(names):
        raise SceneError(f"--csv-in {shown(path)} is not allowed: a line of different keys, then lines of values")
    results = [name for name in names if name in (STATUS, REASON, *RESULTS)]
    if results:
        why = f"its column {results[0]} is what a sweep found, not a key; keep the columns of keys alone"
        raise SceneError(f"--csv-in {shown(path)} is not allowed: {why}")
    rows = []
    lines_of: dict[tuple, int] = {}
    for number, line in enumerate(lines, start=2):
        if not line:
            continue
        cells = [cell.strip() for cell in line]
        if len(cells) != len(names):
            raise SceneError(f"--csv-in {shown(path)}, line {number}: {len(names)} values are needed")
        if "" in cells:
            raise SceneError(f"--csv-in {shown(path)}, line {number}: {names[cells.index('')]} is empty")
        row = {name: read_value(cell) for name, cell in zip(names, cells)}
        if lines_of.setdefault(tuple(map(_comparable, row.values())), number) != number:
            raise SceneError(f"--csv-in {shown(path)}, line {number}: the same row is there twice")
        rows.append(row)
    return rows


def listed(name: str, value, kind: type, allowed: str) -> list:
    """An argument as a list of ``kind``; SceneError, which calls it ``name``, where it is none."""
    entries = list(value) if isinstance(value, Iterable) and not isinstance(value, str) else [None]
    if not all(isinstance(entry, kind) for entry in entries):
        raise SceneError(f"{name} = {shown(value)} is not allowed: {allowed}")
    return entries


def product(
    vary: Mapping[str, Sequence] | Sequence[Mapping[str, Any]], rows: Sequence[Changes] = ({},)
) -> list[Changes]:
    """Every combination of the values, the last key's fastest, each with every row; or the rows alone.

    SceneError where nothing varies, a key has no or the same value twice, or a key is in both.
    """
    if not isinstance(vary, Mapping):
        rows, vary = listed("vary", vary, Mapping, "lists of values by key, or a list of dictionaries"), {}
    for key, values in vary.items():
        if isinstance(values, str) or not isinstance(values, Iterable):
            raise SceneError(f"{key} = {shown(values)} is not allowed: a list of the values that it is to take")
    columns = {key: [_plain(value) for value in values] for key, values in vary.items()}
    for key, values in columns.items():
        if not values:
            raise SceneError(f"{key} is to vary but has no value")
        places: dict[Any, int] = {}
        for i, value in enumerate(values):
            if places.setdefault(_comparable(value), i) != i:
                raise SceneError(f"{key} = {shown(value)} is to vary but is there twice")
        if any(key in row for row in rows):
            raise SceneError(f"{key} is to vary in two ways: as a key of its own and in a table")
    if not columns and not any(rows):
        raise SceneError("nothing varies: vary has no key with values")
    count = len(rows)
    for values in columns.values():
        count *= len(values)
    if count > MOST:
        raise SceneError(f"{count} scenes are too many: {MOST} are allowed")
    cases = [dict(zip(columns, values)) for values in itertools.product(*columns.values())]
    return [{key: _plain(value) for key, value in row.items()} | case for row in rows for case in cases]


def _comparable(value):
    """What is the same for equal values and can be looked up: a number itself, the text of anything else."""
    return value if isinstance(value, (int, float)) else written(value)


def base_of(scene) -> str:
    """TOML text of a scene that is to be varied: a text, a file, changes of none (all keys by name), or a Scene."""
    if isinstance(scene, Scene):
        return scene.to_toml()
    if isinstance(scene, Mapping):
        return keys_alone(flatten(dict(scene)))
    text = text_of(scene, "scene")
    read_keys(text)
    return text


def keys_alone(keys: Mapping[str, Any]) -> str:
    """Flat keys as TOML, a line each, in the order of their names."""
    return "".join(f"{key} = {written(_plain(value))}\n" for key, value in sorted(keys.items()))


def overrides(changes: Mapping[str, Any]) -> tuple[str, ...]:
    """The changes as ``parse`` takes them."""
    return tuple(f"{key}={written(value)}" for key, value in changes.items())


def check(text: str, sets: tuple[str, ...], cases: list[Changes]):
    """SceneError for a value that no combination takes, and for a key that is set, too. What only some combinations
    refuse is a row of the table.
    """
    for override in sets:
        key = override.partition("=")[0].strip()
        if any(key in changes for changes in cases):
            raise SceneError(f"{key} is to vary, and --set {override} gives it one value")
    refused: dict[tuple[str, str], SceneError] = {}
    accepted: set[tuple[str, str]] = set()
    ordered: set[tuple[str, ...]] = set()  # keys whose order makes no difference
    for changes in cases:
        entries = [(key, written(value)) for key, value in changes.items()]
        try:
            parse(text, (*sets, *overrides(changes)))
        except SceneError as error:
            for entry in entries:
                refused.setdefault(entry, error)
        else:
            accepted.update(entries)
            if tuple(changes) not in ordered:
                _check_order(text, sets, changes)
                ordered.add(tuple(changes))
    never = [entry for entry in refused if entry not in accepted]
    if never:
        blamed = min(never, key=lambda entry: not str(refused[entry]).startswith(f"{entry[0]} = "))  # else the first
        _check_base(text, sets, refused[blamed])
        entry, reason = f"{blamed[0]} = {one_line(blamed[1])}", str(refused[blamed])
        raise SceneError(reason if reason.startswith(entry) else f"{entry} is to vary, but: {reason}")


def _check_base(text: str, sets: tuple[str, ...], reason: SceneError):
    """Raise ``reason`` as it is where nothing that varies is the cause of it."""
    try:
        parse(text, sets)
    except SceneError as alone:
        if str(alone) == str(reason):
            raise reason from None


def _check_order(text: str, sets: tuple[str, ...], changes: Changes):
    """SceneError where one key takes the place of another, as a length that of its ratio: then only the last counts."""
    words = overrides(changes)
    usual, backwards, sets_last = (
        parse(text, order).to_toml() for order in ((*sets, *words), (*sets, *reversed(words)), (*words, *sets))
    )
    if usual != backwards:
        raise SceneError(f"{', '.join(changes)} are to vary, but one of them takes the place of another")
    if usual != sets_last:
        raise SceneError(f"of {', '.join(changes)} to vary one takes the place of a key of --set {', '.join(sets)}")


def _plain(value):
    """A numpy number as a number, a tuple as a list."""
    if isinstance(value, (np.ndarray, np.generic)):
        return value.tolist()
    return [_plain(inner) for inner in value] if isinstance(value, (list, tuple)) else value
