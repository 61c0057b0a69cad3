"""Scenes from text and from flat keys: TOML, ``key=value`` and dictionaries to a Scene."""

from collections.abc import Mapping
from pathlib import Path
from typing import Any

from .effects import Effects
from .errors import SceneError, shown
from .fields import allowed
from .scene import Scene
from .table import fields, unknown
from .tables import ONE_OF_TWO
from .text import flatten, read_keys, read_text, read_value

DEFAULT_SCENE = """\
title = "Figure 11b: positive in-depth grading at the Holl ratio"
[solid]
E0 = 210e9            # Pa, modulus at depth y0
k = 0.3
nu = "holl"           # 1/(2+k), or a number
y0_over_a0 = 10.0     # or  y0 = ... in m
[indenter]
R = 0.1               # m
[load]
P = 1.0e6             # N/m
mu = 0.3
amplitude = 0.9       # Q_A/(mu P)
cycles = 1
"""


def parse(text: str, overrides: tuple[str, ...] = (), name: str = "the scene") -> Scene:
    """Scene from TOML text and ``key=value`` overrides; SceneError says in one line what is wrong.

    name: what it calls a text that is not TOML.
    """
    changes: dict[str, Any] = {}
    given = read_keys(text, name)
    for override in overrides:
        key, equals, value = override.partition("=")
        if not equals or not key.strip():
            raise SceneError(f"--set {shown(override)} is not allowed: KEY=VALUE, for instance load.amplitude=0.6")
        changes = _changed(changes, {key.strip(): read_value(value.strip())})
    return _scene(_changed(given, changes))


def make_scene(
    changes: Mapping[str, Any] | None = None, base: str | Path | Scene | None = DEFAULT_SCENE
) -> Scene:
    """A checked scene: ``base`` (TOML text, a file, a Scene, or None for nothing) with changed keys; or a SceneError.

    changes: ``{"solid.k": 0.5}`` or tables, ``{"solid": {"k": 0.5}}``; a key that is None is taken out.
    """
    if not isinstance(changes, Mapping | None):
        raise SceneError(f"changes = {shown(changes)} are not allowed: keys and values; base may be a pathlib.Path")
    given = {} if base is None else base.to_keys() if isinstance(base, Scene) else read_keys(text_of(base))
    return _scene(_changed(given, flatten(dict(changes or {}))))


def text_of(base: str | Path, name: str = "base") -> str:
    """TOML text, or that of a file; SceneError, which calls it ``name``, where it is neither."""
    if isinstance(base, Path):
        return read_text(base, "scene")
    if not isinstance(base, str) or base.endswith(".toml"):
        raise SceneError(f"{name} = {shown(base)} is not allowed: TOML text, a pathlib.Path, a Scene or None")
    return base


def language() -> dict[str, str]:
    """Every key of the scene language, and what it allows."""
    return {"title": allowed(Scene.model_fields["title"])} | {key: allowed(*found) for key, found in fields().items()}


def _changed(given: Mapping[str, Any], changes: Mapping[str, Any]) -> dict[str, Any]:
    """``given`` with changed keys; a length takes the place of its ratio to a0, and the other way round."""
    replaced = set(changes)
    for pair in ONE_OF_TWO:
        names = {f"solid.{name}" for name in pair}
        if any(changes.get(name) is not None for name in names):
            replaced |= names
    return {name: value for name, value in given.items() if name not in replaced} | dict(changes)


def _scene(keys: Mapping[str, Any]) -> Scene:
    """The scene of flat keys, its effects judged."""
    tables: dict[str, Any] = {}
    for name, value in keys.items():
        if name != "title" and name not in fields():
            raise unknown(name, value)
        if value is None:
            continue
        if name == "title":
            tables[name] = value
        else:
            table, _, inner = name.partition(".")
            tables.setdefault(table, {})[inner] = value
    scene = Scene(**tables)
    Effects(scene)  # an effect may refuse the scene
    return scene
