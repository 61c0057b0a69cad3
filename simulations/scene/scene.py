"""The scene language: a TOML file in the paper's symbols and SI units, checked key by key."""

import difflib
from dataclasses import dataclass
from functools import cached_property
from math import isfinite
from pathlib import Path
from typing import Any

import numpy as np

from analytic import CylinderContact, GradedHalfPlane, ProfileContact

from . import accuracy, effects
from .indenter import Indenter, from_scene
from .language import SceneError, one_line, shown
from .solid import equivalent_half_width, normal_contact
from .text import read_keys, read_value, written
from .vocabulary import INSTEAD_OF_POINTS, NEEDED, OWN_KEYS, TANGENTIAL, THICKNESS, Y0, language

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


@dataclass(frozen=True)
class Scene:
    """A checked scene. ``values`` holds the keys that apply to it, resolved to numbers in SI units."""

    values: dict[str, Any]

    def __getitem__(self, key: str):
        return self.values[key]

    def __reduce__(self):  # what it has worked out stays behind
        return Scene, (self.values,)

    def section(self, name: str) -> dict[str, Any]:
        """The keys of one table, without its name."""
        return {key.partition(".")[2]: v for key, v in self.values.items() if key.startswith(name + ".")}

    @property
    def cell_sizes(self) -> dict[str, float]:
        """What ``mesh.Grading`` takes besides the edges."""
        return {name: value for name, value in self.section("mesh").items() if name not in ("degree", "edges")}

    @property
    def friction(self) -> bool:
        """True with a tangential problem."""
        return self["effects.friction"]

    @property
    def is_loop(self) -> bool:
        """True for the fretting programme, to Q_A and then cycles, at constant P."""
        return self.friction and "load.points" not in self.values

    @property
    def P(self) -> float:
        """Largest normal line load, N/m."""
        return max(P for P, _ in self["load.points"]) if "load.points" in self.values else self["load.P"]

    @property
    def k(self) -> float:
        """Exponent of the modulus on the surface."""
        return self.values.get("solid.k", 0.0) if self["effects.grading"] else 0.0

    @property
    def is_power_law(self) -> bool:
        """True where (1) holds at every depth, with k = 0 too."""
        return self["solid.modulus"] in ("power law", "homogeneous") or not self["effects.grading"]

    @cached_property
    def solid(self) -> GradedHalfPlane:
        """The half-plane of (1); for a coating, the one that it is near the surface."""
        y0 = self.values.get("solid.y0", 1.0)
        return GradedHalfPlane(E0=self["solid.E0"], nu=self["solid.nu"], k=self.k, y0=y0)

    @cached_property
    def indenter(self) -> Indenter:
        """The profile f(x), m."""
        return from_scene(self.values)

    @cached_property
    def contact(self) -> CylinderContact | ProfileContact | None:
        """Closed form of the frictionless contact under P, (42)-(46) or (5)-(8); None for a coating."""
        return normal_contact(self.solid, self.indenter, self.P) if self.is_power_law else None

    @cached_property
    def half_width(self) -> float:
        """The contact half-width a, m; for a coating an estimate of it."""
        return self.contact.a if self.contact else equivalent_half_width(self)

    @cached_property
    def a0(self) -> float:
        """The contact half-width on a homogeneous half-plane of modulus E0 (57), m."""
        return normal_contact(GradedHalfPlane(self["solid.E0"], self["solid.nu"], 0.0, 1.0), self.indenter, self.P).a

    @property
    def is_decoupled(self) -> bool:
        """True at the Holl ratio, where normal and tangential problem do not see each other."""
        return self.is_power_law and abs(self["solid.nu"] * (2.0 + self.k) - 1.0) < 1e-9

    @property
    def has_closed_form(self) -> bool:
        """True where the closed forms describe the same problem: uncoupled, by nature or by choice."""
        if not self.is_power_law or (self.friction and not self.is_loop):
            return False
        return self.is_decoupled or not (self.friction and self["effects.coupling"])

    def to_toml(self) -> str:
        """The resolved scene as TOML, which can be run again."""
        tables: dict[str, dict] = {}
        for key, value in self.values.items():
            table, _, name = key.rpartition(".")
            tables.setdefault(table, {})[name] = value
        lines = []
        for table, entries in tables.items():
            lines += [f"[{table}]"] if table else []
            lines += [f"{name} = {written(value)}" for name, value in entries.items()]
        return "\n".join(lines) + "\n"


def parse(text: str, overrides: tuple[str, ...] = ()) -> Scene:
    """Scene from TOML text and ``key=value`` overrides; SceneError says in one line what is wrong."""
    given = read_keys(text)
    for override in overrides:
        key, equals, value = override.partition("=")
        if not equals:
            raise SceneError(f"--set {shown(override)} is not allowed: KEY=VALUE, for instance load.amplitude=0.6")
        for pair in (Y0, THICKNESS):
            for other in pair if key.strip() in pair else ():
                given.pop(other, None)
        given[key.strip()] = read_value(value.strip())
    return resolve(given)


def resolve(given: dict[str, Any]) -> Scene:
    """Scene from flat keys: checks each, fills defaults, turns "holl" and multiples of a0 into numbers."""
    keys = language()
    for name in given:
        if name not in keys:
            hint = _hint(name, keys)
            raise SceneError(f"{shown(Path(name))} = {shown(given[name])} is not a key of the scene language: {hint}")
    given = {name: keys[name].read(name, value) for name, value in given.items()}
    _derive(given)
    _choose_mesh(given)
    out = _check_combination(given)
    values: dict[str, Any] = {}
    for name, key in keys.items():
        if name in given:
            values[name] = key.read(name, given[name])
        elif key.default is not None and name not in out:
            values[name] = key.default
    scene = Scene(_resolve_words(values, keys))
    _check_size(scene)
    if "incompressibility" in effects.Effects(scene) and scene["mesh.degree"] == 1:
        raise SceneError("mesh.degree = 1 is not allowed with mixed unknowns: 2 or 3")
    return scene


def _hint(name: str, keys) -> str:
    """The key that was meant, or those that there are."""
    bare = {key.rpartition(".")[2].lower(): key for key in keys}
    same = bare.get(name.rpartition(".")[2].lower())
    close = [same] if same else difflib.get_close_matches(name, keys, n=1)
    if close:
        return f"did you mean {close[0]}?"
    table = name.partition(".")[0] + "."
    inside = [key for key in keys if key.startswith(table)]
    tables = dict.fromkeys(key.partition(".")[0] for key in keys if "." in key)
    return f"there are {', '.join(inside)}" if inside else f"there are title and the tables {', '.join(tables)}"


def _derive(given: dict[str, Any]):
    """What follows from other keys: friction from a tangential load, the full method from theta."""
    if "effects.friction" not in given:
        points = given.get("load.points")
        tangential = any(name in given for name in TANGENTIAL)
        given["effects.friction"] = tangential or bool(isinstance(points, list) and "load.mu" in given)
    theta = given.get("solver.theta", 0)
    if theta != 0 and given.setdefault("solver.method", "full") != "full":
        raise SceneError('solver.theta other than 0 needs solver.method = "full"')
    if theta != 0 and given.get("effects.coupling") is False:
        raise SceneError(
            "solver.theta other than 0 needs effects.coupling = true: the pressure held is that of theta = 0"
        )


def _choose_mesh(given: dict[str, Any]):
    """Cell sizes from the accuracy wanted."""
    if "solver.accuracy" not in given:
        return
    key, k = "solver.accuracy", given.get("solid.k", 0.0)
    wanted = OWN_KEYS[key].read(key, given[key])
    k = OWN_KEYS["solid.k"].read("solid.k", k) if k else 0.0
    k = k if given.get("effects.grading", True) else 0.0
    amplitude = OWN_KEYS["load.amplitude"].read("load.amplitude", given.get("load.amplitude", 0.9))
    for name, value in accuracy.choose(wanted, k, amplitude).mesh.items():
        if given.setdefault(name, value) != value:
            raise SceneError(f"{name} = {given[name]!r} is not allowed beside solver.accuracy, which chooses {value:g}")


def _check_combination(given: dict[str, Any]) -> set[str]:
    """SceneError for keys that are missing or do not go together; returns those that do not apply."""
    out: set[str] = set()

    def leave_out(names, beside):
        for name in names:
            if name in given:
                raise SceneError(f"{name} = {shown(given[name])} is not allowed beside {beside}")
        out.update(names)

    def need(names):
        names = names if isinstance(names, tuple) else (names,)
        present = [name for name in names if name in given]
        if not present:
            allowed = " or ".join(f"{name}: {OWN_KEYS[name].allowed}" for name in names)
            raise SceneError(f"{names[0]} is missing: {allowed.removeprefix(names[0] + ': ')}")
        if len(present) > 1:
            raise SceneError(f"exactly one of {' and '.join(names)} is to be given")

    need("solid.E0")
    need("solid.nu")
    for choice, by_value in NEEDED.items():
        value = OWN_KEYS[choice].read(choice, given.get(choice, OWN_KEYS[choice].default))
        mine = [(n,) if isinstance(n, str) else n for n in by_value[value]]
        for names in mine:
            need(names if len(names) > 1 else names[0])
        everything = {m for names in by_value.values() for n in names for m in ((n,) if isinstance(n, str) else n)}
        optional = {"indenter.R"} if value == "formula" else set()
        leave_out(sorted(everything - {n for names in mine for n in names} - optional), f'{choice} = "{value}"')
    if "load.points" in given:
        leave_out(INSTEAD_OF_POINTS, "load.points")
    else:
        need("load.P")
    if given["effects.friction"] is False:
        leave_out((*TANGENTIAL, "effects.friction_in_normal_stage"), "effects.friction = false")
    else:
        need("load.mu")
        if "load.points" not in given:
            need("load.amplitude")
    return out


def _resolve_words(values: dict[str, Any], keys) -> dict[str, Any]:
    if values["solid.nu"] == "holl":
        k = values.get("solid.k", 0.0)
        if k < 0 or values["solid.modulus"] not in ("power law", "homogeneous"):
            raise SceneError(f'solid.nu = "holl" is not allowed: needs a power law with k >= 0, here k = {k:g}')
        values["solid.nu"] = GradedHalfPlane.holl_ratio(k)
    for length, ratio in (Y0, THICKNESS):
        if ratio in values:
            values[length] = values.pop(ratio) * _fitting(Scene(values), "a0")
    return {name: values[name] for name in keys if name in values}


def _check_size(scene: Scene):
    """SceneError where the numbers, each allowed, make a contact that does not exist or that no float holds."""
    a = _fitting(scene, "half_width")
    defect = scene.indenter.defect(1.5 * a)
    if defect:
        profile = scene["indenter.profile"]
        key, value = ("formula", one_line(scene["indenter.formula"])) if profile == "formula" else ("profile", profile)
        raise SceneError(f'indenter.{key} = "{value}" is not allowed: {defect}')
    if "load.points" in scene.values:
        _check_points(scene["load.points"], scene.values.get("load.mu"))


def _fitting(scene: Scene, size: str) -> float:
    try:
        with np.errstate(all="ignore"):
            value = float(getattr(scene, size))
        pressure = scene.P / value
    except SceneError:
        raise
    except (ArithmeticError, ValueError, TypeError, NotImplementedError, RecursionError) as error:
        raise SceneError(f"the scene's numbers do not fit together: {one_line(str(error))}") from None
    if not all(isfinite(v) and v > 0 for v in (value, pressure)):
        raise SceneError(f"the scene's numbers do not fit together: {size} = {value:g} m, P/a = {pressure:g} Pa")
    return value


def _check_points(points, mu):
    if mu is None and any(Q for _, Q in points):
        raise SceneError(f"load.mu is missing: load.points has Q; {OWN_KEYS['load.mu'].allowed}")
    if points[0][1] != 0:
        raise SceneError(f"load.points = {shown(points)} is not allowed: the first point has Q = 0")
    for P, Q in points:
        if Q and abs(Q) >= mu * P:
            raise SceneError(f"load.points = {shown(points)} is not allowed: |Q| < mu P, here P = {P:g}, Q = {Q:g}")
