"""From tables as they are given to typed tables of numbers: what follows from other keys, lengths in half-widths."""

from collections.abc import Callable, Mapping
from functools import partial
from math import isfinite
from typing import Any

import numpy as np

from . import accuracy
from .errors import SceneError, one_line, shown
from .fields import allowed, plain
from .indenter import named, shape_of
from .output import Output
from .settings import EffectSwitches, Mesh, Reference, Solver, switches
from .solid import homogeneous_half_width, material
from .steepness import look_at
from .table import KINDS, Table, fields, model_for, unknown
from .tables import ONE_OF_TWO, TANGENTIAL, AnyIndenter, AnyLoad, AnySolid
from .tables import Formula, Fretting, Indentation, Path

ON_AN_ELLIPSE = 12  # load steps a quarter: with 6 points turn so late that the energy is off by 1.7 %, with 12 by 0.5 %
NEEDED = "f is to be 0 at 0, positive beside it, and convex as far as contact reaches"


def typed_tables(given: Mapping[str, Any]) -> dict[str, Table]:
    """The tables of a scene, resolved, by name; SceneError where one is wrong or two do not go together.

    given: tables by name, each a model or a dictionary of its keys.
    """
    raw = {table: _keys(table, given.get(table, {})) for table in KINDS}
    for name in given:
        if name not in KINDS:
            raise unknown(str(name), given[name])
    solid: AnySolid = model_for("solid", raw["solid"])(**raw["solid"])
    indenter: AnyIndenter = model_for("indenter", raw["indenter"])(**raw["indenter"])
    effects = _effects(raw["effects"], raw["load"])
    load = _load(raw["load"], effects.friction)
    steps = {"increments": ON_AN_ELLIPSE} if isinstance(load, Fretting) and load.strain_lags else {}
    solver = Solver(**(steps | raw["solver"]))
    reference = Reference(**raw["reference"])
    if solver.accuracy is not None:
        asked = accuracy.of_scene(load, material(solid, effects.grading), effects.coupling)
        _choose_mesh(raw, accuracy.choose(solver.accuracy, *asked, share=accuracy.share_for(reference.kind)))
    return {
        "solid": _in_metres(solid, indenter, load),
        "indenter": indenter,
        "load": load,
        "mesh": Mesh(**raw["mesh"]),
        "solver": solver,
        "reference": reference,
        "effects": effects,
        "output": Output(**raw["output"]),
    }


def _keys(table: str, value) -> dict[str, Any]:
    """The keys that a table is given as; SceneError where one is none of the scene language."""
    if isinstance(value, Table) and value.table == table:
        return value.given()
    if not isinstance(value, Mapping):
        raise unknown(table, value)
    for name in value:
        if f"{table}.{name}" not in fields():
            raise unknown(f"{table}.{name}", value[name])
    return dict(value)


def _effects(given: dict[str, Any], load: Mapping[str, Any]) -> EffectSwitches:
    """Switches of effects: friction is on where the load has a key of it."""
    tangential = [name for name in TANGENTIAL if name in load]
    effects = switches({"friction": bool(tangential)} | given)
    if not effects.friction:
        beside = "is not allowed beside effects.friction = false"
        for name in tangential:
            raise SceneError(f"load.{name} = {shown(plain(load[name]))} {beside}")
        if effects.friction_in_normal_stage:
            raise SceneError(f"effects.friction_in_normal_stage = true {beside}")
    return effects


def _load(given: dict[str, Any], friction: bool) -> AnyLoad:
    if "points" not in given:
        return (Fretting if friction else Indentation)(**given)
    path = Path(**given)
    if friction and path.mu is None:
        raise SceneError(f"load.mu is missing: {allowed(Path.model_fields['mu'])}")
    return path


def _choose_mesh(raw: dict[str, dict[str, Any]], choice: accuracy.Choice):
    """Put the cell sizes for an accuracy into the tables; SceneError where others are given."""
    for key, value in choice.mesh.items():
        table, _, name = key.partition(".")
        given = plain(raw[table].setdefault(name, value))
        if given != value:
            raise SceneError(f"{key} = {shown(given)} is not allowed beside solver.accuracy, which chooses {value:g}")


def _in_metres(solid: AnySolid, indenter: AnyIndenter, load: AnyLoad) -> AnySolid:
    """The solid with lengths in m that were given as multiples of a0."""
    for length, ratio in ONE_OF_TWO:
        multiple = getattr(solid, ratio, None)
        if multiple is not None:
            half_width = partial(homogeneous_half_width, solid.E0, solid.nu)
            a0 = fitting("a0", lambda: half_width(shape_of(indenter), load.P), solid, indenter, load)
            others = {name: value for name, value in solid.given().items() if name != ratio}
            solid = type(solid)(**others, **{length: multiple * a0})
    return solid


def fitting(
    name: str, work_out: Callable[[], float], solid: AnySolid, indenter: AnyIndenter, load: AnyLoad
) -> float:
    """A size of the contact; SceneError where numbers, each allowed, make one that does not exist or that no float
    holds.
    """
    try:
        with np.errstate(all="ignore"):
            value = float(work_out())
        pressure = load.P / value
    except SceneError:
        raise
    except (ArithmeticError, ValueError, TypeError, NotImplementedError, RecursionError) as error:
        reason = one_line(str(error))
        if isinstance(indenter, Formula) and not isinstance(error, ArithmeticError):
            raise SceneError(f"{named(indenter)} is not allowed: {NEEDED} ({reason})") from None
    else:
        if all(isfinite(v) and v > 0 for v in (value, pressure)):
            return value
        reason = f"{name} = {value:g} m, P/a = {pressure:g} Pa"
    raise SceneError(f"the scene's numbers do not fit together: {reason}; {look_at(solid, indenter, load)}")
