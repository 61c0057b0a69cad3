"""How steep the indenter is where contact ends: f'(a), which for a cylinder is a/R. Small strains want it small.

A contact too wide for its indenter is what shows of a wrong unit before a run.
"""

from .errors import SceneError, shown
from .indenter import shape_of
from .tables import AnyIndenter, AnyLoad, AnySolid, Formula, Path, Tabulated

SMALL = 0.2  # a parabola is lower than its circle by f'(a)²/4 of itself: here 1 %
SOLID = {"E0": "Pa", "E_substrate": "Pa", "k": "", "y0": "m", "thickness": "m"}  # keys with units
STEEP = 1.0  # 45 degrees; a cylinder has a = R


def check_steepness(a: float, solid: AnySolid, indenter: AnyIndenter, load: AnyLoad):
    """SceneError where the indenter stands at 45 degrees or more at the edges x = ±a of contact."""
    slope = edge_slope(a, indenter)
    if slope >= STEEP:
        allowed = f"only less than {STEEP:g} is allowed; {look_at(solid, indenter, load)}"
        raise SceneError(f"{_where(a, indenter)} {slope:.3g}, and {allowed}")


def steepness_warning(a: float, indenter: AnyIndenter) -> str:
    """What to say of an indenter that is steeper than the theory is good for; "" where it is not."""
    slope = edge_slope(a, indenter)
    if slope <= SMALL:
        return ""
    return f"{_where(a, indenter)} {slope:.2g}; up to {SMALL:g} strains are small and a parabola is a circle to 1 %"


def edge_slope(a: float, indenter: AnyIndenter) -> float:
    """The slope of the indenter where contact ends."""
    return float(shape_of(indenter).slope(a))


def look_at(solid: AnySolid, indenter: AnyIndenter, load: AnyLoad) -> str:
    """The keys that make a contact wide, with value and unit: what to look at where it is too wide."""
    P = f"load.points, P up to {load.P:g} N/m" if isinstance(load, Path) else f"load.P = {load.P:g} N/m"
    given = [(f"solid.{name}", solid.given().get(name), unit) for name, unit in SOLID.items()]
    keys = [f"{key} = {value:.3g} {unit}".rstrip() for key, value, unit in given if value is not None]
    keys += ["solid.points"] * isinstance(solid, Tabulated)
    return f"look at {', '.join(keys)}, {P}, {_size(indenter)}"


def _where(a: float, indenter: AnyIndenter) -> str:
    return f"a = {a:.3g} m on {_size(indenter)}: the slope of the indenter where contact ends is"


def _size(indenter: AnyIndenter) -> str:
    formula = [f"indenter.formula = {shown(indenter.formula)}"] if isinstance(indenter, Formula) else []
    return ", ".join(formula + ([f"indenter.R = {indenter.R:g} m"] if indenter.R is not None else []))
