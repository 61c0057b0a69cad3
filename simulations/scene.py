"""The scene language: a TOML file in the paper's symbols and SI units, checked key by key."""

import difflib
import json
import tomllib
from dataclasses import dataclass
from functools import cached_property
from math import inf, isfinite
from typing import Any

from analytic import CylinderContact, GradedHalfPlane

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


class SceneError(ValueError):
    """A scene or command line that cannot be run; the message is one line for the user."""


@dataclass(frozen=True)
class Key:
    """One key of the language: allowed range (open unless ``closed``), default (None: required)."""

    low: float = -inf
    high: float = inf
    default: Any = None
    kind: type = float
    closed: tuple[bool, bool] = (False, False)
    word: str | None = None  # a word that may stand for the number
    choices: tuple[str, ...] = ()  # of a text

    @property
    def allowed(self) -> str:
        """What may be written, in words."""
        if self.kind is str:
            return " or ".join(map(json.dumps, self.choices)) or "a text"
        left, right = ("[" if self.closed[0] else "]"), ("]" if self.closed[1] else "[")
        if self.kind is bool:
            return "true or false"
        kind = "an integer" if self.kind is int else "a number"
        word = f' or "{self.word}"' if self.word else ""
        return f"{kind} in {left}{self.low:g}, {self.high:g}{right}{word}"

    def read(self, name: str, value):
        """``value`` as this key's type, or SceneError naming key, value and what is allowed."""
        if self.kind is str:
            if isinstance(value, str) and (not self.choices or value in self.choices):
                return value
            raise SceneError(f"{name} = {value!r} is not allowed: {self.allowed}")
        if self.kind is bool:
            if isinstance(value, bool):
                return value
            raise SceneError(f"{name} = {value!r} is not allowed: {self.allowed}")
        if self.word and value == self.word:
            return value
        number = isinstance(value, (int, float)) and not isinstance(value, bool) and abs(value) < 1e308
        if number and self.kind is int:
            number = value == int(value) if isfinite(value) else False
        above = number and (value >= self.low if self.closed[0] else value > self.low)
        below = number and (value <= self.high if self.closed[1] else value < self.high)
        if not (number and isfinite(value) and above and below):
            raise SceneError(f"{name} = {value!r} is not allowed: {self.allowed}")
        return self.kind(value)


LANGUAGE: dict[str, Key] = {
    "title": Key(kind=str, default=""),
    "solid.E0": Key(0.0),
    "solid.k": Key(-1.0, 1.0),
    "solid.nu": Key(-1.0, 0.5, word="holl"),
    "solid.y0": Key(0.0),
    "solid.y0_over_a0": Key(0.0),
    "indenter.R": Key(0.0),
    "load.P": Key(0.0),
    "load.mu": Key(1e-6, 100.0, closed=(True, True)),
    "load.amplitude": Key(1e-6, 1.0, closed=(True, False)),
    "load.cycles": Key(0, 1000, 1, int, (True, True)),  # 0: stop at +Q_A
    # what is simulated; friction is on where there is a tangential load
    "effects.friction": Key(kind=bool, default=True),
    "effects.coupling": Key(kind=bool, default=True),
    "effects.friction_in_normal_stage": Key(kind=bool, default=False),
    # cell sizes in contact half-widths a
    "mesh.facet": Key(1e-3, 0.5, 0.025, closed=(True, True)),
    "mesh.edge_facet": Key(1e-6, 0.5, 1e-3, closed=(True, True)),
    "mesh.growth": Key(1.02, 3.0, 1.3, closed=(True, True)),
    "mesh.first_layer": Key(1e-7, 0.5, 1e-3, closed=(True, True)),
    "mesh.layer_growth": Key(1.02, 3.0, 1.3, closed=(True, True)),
    "mesh.extent": Key(4.0, 1e4, 20.0, closed=(True, True)),
    "solver.method": Key(kind=str, default="condensed", choices=("condensed", "full")),
    "solver.normal_increments": Key(1, 1000, 20, int, (True, True)),  # with friction in the normal stage
    "solver.increments": Key(1, 1000, 6, int, (True, True)),  # per quarter cycle
    "solver.gamma0": Key(1e-3, 1e6, 10.0, closed=(True, True)),
    "solver.theta": Key(-1.0, 1.0, 0.0, closed=(True, True)),
    # what a coupled run is compared with besides the closed form: "auto" is the solver that has its physics
    "reference.kind": Key(kind=str, default="auto", choices=("auto", "closed form")),
}
TANGENTIAL = ("load.mu", "load.amplitude", "load.cycles")  # not in a scene without friction
ALTERNATIVES = ("solid.y0", "solid.y0_over_a0")  # exactly one of the two


@dataclass(frozen=True)
class Scene:
    """A checked scene. ``values`` holds every key of LANGUAGE, resolved to numbers in SI units."""

    values: dict[str, Any]

    def __getitem__(self, key: str):
        return self.values[key]

    def section(self, name: str) -> dict[str, Any]:
        """The keys of one table, without its name."""
        return {key.partition(".")[2]: v for key, v in self.values.items() if key.startswith(name + ".")}

    @cached_property
    def solid(self) -> GradedHalfPlane:
        v = self.values
        return GradedHalfPlane(E0=v["solid.E0"], nu=v["solid.nu"], k=v["solid.k"], y0=v["solid.y0"])

    @cached_property
    def contact(self) -> CylinderContact:
        """Closed form of the normal contact, (42)-(46)."""
        return CylinderContact(self.solid, R=self["indenter.R"], P=self["load.P"])

    @property
    def is_decoupled(self) -> bool:
        """True at the Holl ratio, where normal and tangential problem do not see each other."""
        return abs(self["solid.nu"] * (2.0 + self["solid.k"]) - 1.0) < 1e-9

    @property
    def has_closed_form(self) -> bool:
        """True where the closed forms describe the same problem: uncoupled, by nature or by choice."""
        return self.is_decoupled or not (self["effects.friction"] and self["effects.coupling"])

    def to_toml(self) -> str:
        """The resolved scene as TOML, which can be run again."""
        tables: dict[str, dict] = {}
        for key, value in self.values.items():
            table, _, name = key.rpartition(".")
            tables.setdefault(table, {})[name] = value
        lines = []
        for table, entries in tables.items():
            lines += [f"[{table}]"] if table else []
            lines += [f"{name} = {json.dumps(value)}" for name, value in entries.items()]
        return "\n".join(lines) + "\n"


def flatten(document: dict) -> dict[str, Any]:
    """``{"solid": {"k": 0.3}}`` as ``{"solid.k": 0.3}``."""
    flat: dict[str, Any] = {}
    for name, value in document.items():
        entries = {f"{name}.{inner}": v for inner, v in value.items()} if isinstance(value, dict) else {name: value}
        for key, inner in entries.items():
            if key in flat:
                raise SceneError(f"{key} = {inner!r} is given twice")
            flat[key] = inner
    return flat


def parse(text: str, overrides: tuple[str, ...] = ()) -> Scene:
    """Scene from TOML text and ``key=value`` overrides; SceneError says in one line what is wrong."""
    given = _toml(text, "the scene")
    for override in overrides:
        key, equals, value = override.partition("=")
        if not equals:
            raise SceneError(f"--set {override!r} is not allowed: KEY=VALUE, for instance load.amplitude=0.6")
        for other in ALTERNATIVES if key.strip() in ALTERNATIVES else ():
            given.pop(other, None)
        given[key.strip()] = _value(value.strip())
    return resolve(given)


def resolve(given: dict[str, Any]) -> Scene:
    """Scene from flat keys: checks each, fills defaults, turns "holl" and y0_over_a0 into numbers."""
    for name in given:
        if name not in LANGUAGE:
            close = difflib.get_close_matches(name, LANGUAGE, n=1)
            hint = f"did you mean {close[0]}?" if close else "keys are " + ", ".join(LANGUAGE)
            raise SceneError(f"{name} = {given[name]!r} is not a key of the scene language: {hint}")
    if sum(name in given for name in ALTERNATIVES) != 1:
        raise SceneError(f"exactly one of {' and '.join(ALTERNATIVES)} is to be given")
    if given.get("solver.theta", 0) != 0 and given.setdefault("solver.method", "full") != "full":
        raise SceneError('solver.theta other than 0 needs solver.method = "full"')
    if given.get("solver.theta", 0) != 0 and given.get("effects.coupling") is False:
        raise SceneError(
            "solver.theta other than 0 needs effects.coupling = true: the pressure held is that of theta = 0"
        )
    if "effects.friction" not in given and not any(name in given for name in TANGENTIAL):
        given["effects.friction"] = False
    left_out = TANGENTIAL if given.get("effects.friction") is False else ()
    for name in (*left_out, *(["effects.friction_in_normal_stage"] if left_out else [])):
        if name in given:
            raise SceneError(f"{name} = {given[name]!r} is not allowed beside effects.friction = false")
    if given.get("effects.friction_in_normal_stage") is True and given.get("effects.coupling") is False:
        raise SceneError("effects.friction_in_normal_stage = true needs effects.coupling = true: that is its subject")
    values: dict[str, Any] = {}
    for name, key in LANGUAGE.items():
        if name in left_out:
            continue
        if name in given:
            values[name] = key.read(name, given[name])
        elif key.default is not None:
            values[name] = key.default
        elif name not in ALTERNATIVES:
            raise SceneError(f"{name} is missing: {key.allowed}")
    scene = Scene(_resolve_words(values))
    _check_size(scene)
    return scene


def _check_size(scene: Scene):
    """SceneError where the numbers, each allowed, make a contact that no computer number can hold."""
    try:
        sizes = scene.contact.a, scene["solid.y0"], scene.contact.peak_pressure
    except (ArithmeticError, ValueError) as error:
        raise SceneError(f"the scene's numbers do not fit together: {error}") from None
    if not all(isfinite(size) and size > 0 for size in sizes):
        raise SceneError(f"the scene's numbers do not fit together: a, y0, p(0) = {', '.join(f'{s:g}' for s in sizes)}")


def _resolve_words(values: dict[str, Any]) -> dict[str, Any]:
    k = values["solid.k"]
    if values["solid.nu"] == "holl":
        if k <= 0:
            raise SceneError(f'solid.nu = "holl" is not allowed: at k = {k:g} the Holl ratio is not below 1/2')
        values["solid.nu"] = GradedHalfPlane.holl_ratio(k)
    ratio = values.pop("solid.y0_over_a0", None)
    if ratio is not None:
        # a0 does not depend on k and y0: any solid of this E0 and nu has it
        solid = GradedHalfPlane(E0=values["solid.E0"], nu=values["solid.nu"], k=0.0, y0=1.0)
        values["solid.y0"] = ratio * CylinderContact(solid, R=values["indenter.R"], P=values["load.P"]).a0
    return {name: values[name] for name in LANGUAGE if name in values}


def _toml(text: str, what: str) -> dict[str, Any]:
    try:
        return flatten(tomllib.loads(text))
    except tomllib.TOMLDecodeError as error:
        raise SceneError(f"{what} is not TOML: {error}") from None


def _value(text: str):
    """A value as TOML reads it; a bare word is a text."""
    try:
        document = tomllib.loads(f"value = {text}")
    except tomllib.TOMLDecodeError:
        return text
    return document["value"] if len(document) == 1 else text
