"""Words of a page about a run: the scene in sentences, quantities, checks and phases by their names."""

from ..scene import Scene
from ..scene.effects import Effects
from ..scene.tables import RoundedFlat

PREFIXES = ((1e9, "G"), (1e6, "M"), (1e3, "k"), (1.0, ""), (1e-3, "m"), (1e-6, "µ"), (1e-9, "n"))
QUANTITIES = {  # key of summary.json: name, unit
    "a": ("contact half-width a", "m"),
    "a_over_a0": ("a over a0, that of a homogeneous half-plane of modulus E0 under the same P", ""),
    "peak_pressure": ("peak pressure", "Pa"),
    "indentation": ("indentation δ_y", "m"),
    "c_over_a": ("stick half-width over contact half-width, c/a", ""),
    "dissipated_energy": ("dissipated energy ΔW", "J/m"),
}
FIELDS = {"pressure_l2": "pressure p", "traction_l2": "traction q", "slip_l2": "slip"}
CHECKS = {
    "residual": "forces out of balance in the discrete equations, over P",
    "load balance": "integral of p and q less the loads, over P",
    "p >= 0": "largest tension on the surface, over the peak pressure",
    "gap >= 0": "deepest overlap outside the contact, over the depth of the contact",
    "|q| <= mu p": "traction above the friction limit μp, over the largest μp",
    "slip against q": "work that sliding points gain from friction, over the most they can lose",
    "pressure zigzags": "pressure going up and down from node to node, over its range",
    "traction zigzags": "traction going up and down from node to node, over its range",
    "contact has a width": "named states whose contact has too few nodes for a half-width",
    "energy >= 0": "dissipated energy below zero, scaled",
    "error of pressure": "error of the pressure at the worst state, less what the reference's own error explains",
    "error of traction": "the same of the traction",
    "error of a": "the same of the contact half-width, at the last state",
    "error of c": "the same of the stick half-width, at the last state, over the contact half-width",
    "error of dissipated_energy": "the same of the dissipated energy",
}
EFFECTS = {  # what it means that they are on
    "load schedule": "load schedule (cycles or a path)",
    "indenter profile": "indenter profile (other than the parabola)",
}
PHASES = {
    "edges": "rough solution for the edges",
    "mesh": "mesh",
    "forms": "forms and stiffness",
    "solve": "load steps",
    "output": "fields and tables",
    "reference": "reference",
    "files": "picture",
    "total": "in all",
}


def prefixed(size: float, unit: str) -> tuple[float, str]:
    """(factor, unit with prefix) in which a number as large as ``size`` reads 1 to 1000."""
    for factor, prefix in PREFIXES:
        if unit and abs(size) >= factor * 0.9995:
            return factor, prefix + unit
    return 1.0, unit


def quantity(value: float | None, unit: str, digits: int = 5) -> str:
    """A number with its unit: 0.00104426 m is 1.0443 mm; a dash where it is not known."""
    if value is None:
        return "–"
    factor, name = prefixed(value, unit)
    return f"{value / factor:.{digits}g} {name}".strip().replace("-", "−", 1)


def asked(scene: Scene) -> list[str]:
    """The scene in sentences: indenter and solid, loads, and what of the physics is on."""
    return [f"{_indenter(scene)} is pressed onto {_solid(scene)}.", _load(scene), _physics(scene)]


def _indenter(scene: Scene) -> str:
    indenter = scene.indenter
    words = {"power": f"x^{getattr(indenter, 'exponent', 2):g} profile", "formula": "profile"}  # R is no radius there
    name = f"A rigid {words.get(indenter.profile, indenter.profile)}"
    parts = [f"f(x) = {indenter.formula} in metres"] if indenter.profile == "formula" else []
    if indenter.R is not None:
        parts.append(f"{'R =' if indenter.profile in words else 'radius'} {quantity(indenter.R, 'm')}")
    if isinstance(indenter, RoundedFlat):
        parts.append(f"half-width of the flat {quantity(indenter.flat, 'm')}")
    return f"{name} ({', '.join(parts)})"


def _solid(scene: Scene) -> str:
    solid, poisson = scene.material, f"Poisson's ratio {scene.solid.nu:.5g}{' (the Holl ratio)' * scene.is_decoupled}"
    E0 = quantity(solid.E0, "Pa")
    if solid.modulus == "homogeneous":
        return f"a homogeneous half-plane of modulus {E0} and {poisson}"
    if "power" in solid.modulus:
        law = f"whose modulus is E = {E0} (y / {quantity(scene.half_plane.y0, 'm')})^{solid.k:g} at the depth y"
    else:
        deep = quantity(solid.E_substrate, "Pa")
        law = f"with a coating whose modulus goes from {E0} to {deep} ({solid.modulus})"
    thickness = getattr(solid, "thickness", None)
    below = f", constant below {quantity(thickness, 'm')}" if thickness is not None else ""
    return f"a half-plane {law}{below}; {poisson}"


def _load(scene: Scene) -> str:
    load = scene.load
    if scene.is_path:
        points = " → ".join(f"({quantity(P, 'N/m')}, {quantity(Q, 'N/m')})" for P, Q in load.points)
        friction = f"The coefficient of friction is {scene.mu:g}. " if scene.friction else ""
        return f"{friction}The loads (P, Q) go straight from point to point: {points}."
    P = f"The normal line load is P = {quantity(load.P, 'N/m')}"
    if not scene.is_loop:
        return f"{P}; there is no tangential load."
    Q = f"Q_A = {load.amplitude} μP = {quantity(load.amplitude * scene.mu * load.P, 'N/m')}"
    often = "once" if load.cycles == 1 else f"{load.cycles} times"
    back = f", then {often} to −Q_A and back" if load.cycles else " and stays there"
    friction = f"the coefficient of friction μ = {scene.mu:g}"
    return f"{P}, {friction}. The tangential line load goes to {Q}{back}.{_strain(scene)}"


def _strain(scene: Scene) -> str:
    if not scene.bulk_strain:
        return ""
    sense, phase = "tension" if scene.bulk_strain > 0 else "compression", scene.bulk_phase
    lag = f"{abs(phase):g}° {'after' if phase > 0 else 'before'}" if phase and phase != "constant" else "at"
    size = f"{scene.bulk_strain:.4g} ({sense} {lag} +Q_A)"
    return f" The body is strained along the surface by {size}, {strain_course(scene)}."


def strain_course(scene: Scene) -> str:
    """How the bulk strain goes with Q."""
    phase = scene.bulk_phase
    if phase == "constant":
        return "with Q up to Q_A, and stays"
    return f"{abs(phase):g}° {'behind' if phase > 0 else 'ahead of'} Q" if phase else "with Q"


def _physics(scene: Scene) -> str:
    verdicts = Effects(scene).verdicts
    on, off = (
        ", ".join(EFFECTS.get(name, name) for name, v in verdicts.items() if v.on is which) or "none"
        for which in (True, False)
    )
    note = " Coupling vanishes at the Holl ratio." if scene.is_decoupled and verdicts["coupling"].on else ""
    return f"Effects that are on: {on}; off: {off}.{note}"
