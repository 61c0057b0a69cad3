"""The words of the scene language: every key with its range and default, and which keys go together."""

from . import effects
from .language import Key

OWN_KEYS: dict[str, Key] = {
    "title": Key(kind=str, default=""),
    "solid.modulus": Key(
        kind=str,
        default="power law",
        choices=("power law", "homogeneous", "power-law coating", "linear", "exponential"),
    ),
    "solid.E0": Key(0.0),  # at depth y0; on the surface where there is no y0
    "solid.nu": Key(-1.0, 0.5, word="holl", closed=(False, True)),
    "solid.k": Key(-1.0, 1.0),
    "solid.y0": Key(0.0),
    "solid.y0_over_a0": Key(0.0),
    "solid.E_substrate": Key(0.0),
    "solid.thickness": Key(0.0),
    "solid.thickness_over_a0": Key(0.0),
    "indenter.profile": Key(
        kind=str, default="parabola", choices=("parabola", "circle", "power", "rounded flat", "formula")
    ),
    "indenter.R": Key(0.0),
    "indenter.exponent": Key(1.0, 20.0, closed=(False, True)),  # f = R (|x|/R)^m / m
    "indenter.flat": Key(0.0),  # half-width
    "indenter.formula": Key(kind=str),  # f(x) for x >= 0, m
    "load.P": Key(0.0),
    "load.mu": Key(1e-6, 100.0, closed=(True, True)),
    "load.amplitude": Key(1e-6, 1.0, closed=(True, False)),
    "load.cycles": Key(0, 1000, 1, int, (True, True)),  # 0: stop at +Q_A
    "load.points": Key(kind=list),  # [P, Q] in N/m, instead of P, amplitude and cycles
    # cell sizes in contact half-widths a; extent in those, or coating thicknesses where that is more
    "mesh.facet": Key(1e-3, 0.5, 0.025, closed=(True, True)),
    "mesh.edge_facet": Key(1e-6, 0.5, 1e-3, closed=(True, True)),
    "mesh.growth": Key(1.02, 3.0, 1.3, closed=(True, True)),
    "mesh.first_layer": Key(1e-7, 0.5, 1e-3, closed=(True, True)),
    "mesh.layer_growth": Key(1.02, 3.0, 1.3, closed=(True, True)),
    "mesh.edge_at": Key(0.0, 1.0, closed=(True, True)),  # where in its facet an edge lies
    "mesh.extent": Key(4.0, 1e4, 20.0, closed=(True, True)),
    "mesh.degree": Key(1, 3, 2, int, (True, True)),  # of the displacements
    # where the mesh is fine: at edges where the load turns, or at those of all states A to E of Figure 11
    "mesh.edges": Key(kind=str, default="turns", choices=("turns", "states")),
    "solver.method": Key(kind=str, default="condensed", choices=("condensed", "full")),
    "solver.normal_increments": Key(1, 1000, 20, int, (True, True)),  # with friction in the normal stage
    "solver.increments": Key(1, 1000, 6, int, (True, True)),  # per quarter cycle, or from point to point
    "solver.gamma0": Key(1e-3, 1e6, 10.0, closed=(True, True)),
    "solver.accuracy": Key(0.0, 0.5),  # largest relative error wanted; chooses the cell sizes
    "solver.theta": Key(-1.0, 1.0, 0.0, closed=(True, True)),
    # what a run is compared with: "auto" is what has its physics
    "reference.kind": Key(kind=str, default="auto", choices=("auto", "closed form", "half-plane", "none")),
}
Y0, THICKNESS = ("solid.y0", "solid.y0_over_a0"), ("solid.thickness", "solid.thickness_over_a0")  # one of each two
# by choice: keys that are needed, and allowed, with it alone; a tuple inside stands for one of its keys
NEEDED: dict[str, dict[str, tuple[str | tuple[str, ...], ...]]] = {
    "solid.modulus": {
        "power law": ("solid.k", Y0),
        "homogeneous": (),
        "power-law coating": ("solid.k", Y0, THICKNESS),
        "linear": ("solid.E_substrate", THICKNESS),
        "exponential": ("solid.E_substrate", THICKNESS),
    },
    "indenter.profile": {
        "parabola": ("indenter.R",),
        "circle": ("indenter.R",),
        "power": ("indenter.R", "indenter.exponent"),
        "rounded flat": ("indenter.R", "indenter.flat"),
        "formula": ("indenter.formula",),
    },
}
TANGENTIAL = ("load.mu", "load.amplitude", "load.cycles")  # not in a scene without friction
INSTEAD_OF_POINTS = ("load.P", "load.amplitude", "load.cycles")


def language() -> dict[str, Key]:
    """Every key."""
    return OWN_KEYS | effects.keys()
