"""The cases of the study of cost, as data: which problem, which setting is varied, to which level."""

from dataclasses import dataclass, field

from ...scene import accuracy

LOOP = """\
[solid]
E0 = 210e9
k = {k}
nu = {nu}
y0_over_a0 = 10.0
[indenter]
R = 0.1
[load]
P = 1.0e6
mu = 0.3
amplitude = 0.9
[effects]
coupling = {coupling}
"""
UNCOUPLED = {f"k={k:g}": LOOP.format(k=k, nu=0.3, coupling="false") for k in (-0.5, 0.0, 0.7)}
PROBLEMS = {"default": LOOP.format(k=0.3, nu='"holl"', coupling="true")} | UNCOUPLED
TABLE = {
    f"k={k:g}": LOOP.format(k=k, nu=0.3, coupling="false") for k in (-0.25, 0.9)
}  # for the table of accuracy.py alone
COUPLED = {f"coupled k={k:g}": LOOP.format(k=k, nu=0.3, coupling="true") for k in (-0.5, -0.25, 0.0, 0.3, 0.7)}
PEER = LOOP.format(k=0.0, nu=0.495, coupling="true")
GETFEM = {  # by fineness: growth of its layers, extent, mixed form; the first is to be as cheap as it can
    4.0: (2.0, 20.0, False),
    2.8: (1.6, 100.0, True),
    2.0: (1.6, 100.0, True),
    1.4: (1.6, 100.0, True),
}
FINENESS = (8.0, 4.0, 2.8, 2.0, 1.4, 1.0, 0.7, 0.5, 0.35, 0.25)
VARIED = {  # one at a time, around the default settings
    "mesh.facet": (0.2, 0.1, 0.05, 0.0125, 0.00625),
    "mesh.growth": (2.0, 1.6, 1.15, 1.08),
    "mesh.edge_facet": (2e-2, 5e-3, 2e-4),
    "mesh.first_layer": (2e-2, 5e-3, 2e-4),
    "mesh.layer_growth": (2.0, 1.6, 1.15, 1.08),
    "mesh.extent": (5.0, 10.0, 40.0, 80.0),
    "solver.increments": (1, 2, 3, 10, 20),
    "tolerance": (1e-3, 1e-5, 1e-7, 1e-11),
}
SWEPT = {  # the coarse meshes of a sweep
    "mesh.facet": 0.1,
    "mesh.edge_facet": 0.02,
    "mesh.growth": 1.6,
    "mesh.first_layer": 0.02,
    "mesh.layer_growth": 1.6,
    "solver.increments": 2,
}
SIZES = ((0.1, 2e4), (0.025, 1e5), (0.01, 2e5), (0.004, 5e5), (0.0035, 1e6))  # facet and roughly the unknowns it gives


@dataclass(frozen=True)
class Case:
    """One run: its study, problem and level; keys of the scene that it sets; ranks; Newton's tolerance on forces."""

    study: str
    problem: str
    level: str
    sets: dict = field(default_factory=dict)
    ranks: int = 1
    tolerance: float = 1e-9

    @property
    def name(self) -> str:
        """Unique."""
        return f"{self.study}/{self.problem}/{self.level}"

    @property
    def text(self) -> str:
        """Its scene."""
        return PEER if self.study == "peer" else (PROBLEMS | TABLE | COUPLED)[self.problem]

    @property
    def k(self) -> float:
        """Grading."""
        return 0.3 if self.problem == "default" else 0.0 if self.study == "peer" else float(self.problem.split("=")[1])


def cases(with_getfem: bool = True) -> list[Case]:
    """All of them; those that many others are compared with first."""
    found = []
    for problem in PROBLEMS | TABLE | COUPLED:
        k = Case("", problem, "").k
        finest = 0.5 if k < 0 else 0.25 if k < 0.5 else 0.35  # beyond, nothing is gained or nothing is needed
        if problem in COUPLED:  # edges turn at twice as many places
            finest = 1.4 if k < 0 else 1.0
        meshes = {f"{t:g}": accuracy.family(t, k, problem in COUPLED) for t in FINENESS if t >= finest}
        found += [Case("fineness", problem, t, mesh) for t, mesh in meshes.items()]
        found += [Case("half load", problem, t, mesh | {"load.amplitude": 0.5}) for t, mesh in meshes.items()]
    for problem in PROBLEMS:
        for degree in (1, 2, 3):
            for facet in (0.2, 0.1, 0.05, 0.025) if degree > 1 else (0.1, 0.05, 0.025, 0.0125):
                sizes = {
                    "mesh.facet": facet,
                    "mesh.edge_facet": 1.6 * facet**2,
                    "mesh.growth": min(2.0, 1.3 ** (facet / 0.025)),
                }
                found.append(Case("degree", problem, f"{degree}:{facet:g}", sizes | {"mesh.degree": degree}))
    for problem in PROBLEMS:
        found.append(Case("one at a time", problem, "centre"))
        for key, levels in VARIED.items():
            for level in levels:
                sets = {} if key == "tolerance" else {key: level}
                tolerance = level if key == "tolerance" else 1e-9
                found.append(Case("one at a time", problem, f"{key}={level:g}", sets, tolerance=tolerance))
    found += [Case("method", "default", m, {"solver.method": m}) for m in ("condensed", "full")]
    for facet, unknowns in SIZES:
        sizes = {"mesh.facet": facet, "mesh.edge_facet": 0.05 * facet, "mesh.growth": 1.2, "mesh.layer_growth": 1.15}
        sizes |= {"mesh.first_layer": 1e-4, "solver.increments": 10}
        if unknowns < 5e4:
            sizes |= {"mesh.growth": 2.0, "mesh.layer_growth": 1.3}
        if unknowns > 8e5:
            sizes |= {"mesh.layer_growth": 1.1}
        for ranks in (1, 2):
            found.append(Case("size", "default", f"{unknowns:.0e} on {ranks}", sizes, ranks))
    found += [Case("peer", "peer", f"{t:g}", accuracy.family(t, 0.0) | {"solver.increments": 10}) for t in FINENESS[:7]]
    ways = [("20 commands", 1), ("one sweep of 20", 1), ("one sweep of 20, with folders", 1), ("one sweep of 20", 2)]
    found += [Case("sweep", "k=0", f"{level} on {ranks}", SWEPT, ranks) for level, ranks in ways]
    if with_getfem:
        found += [Case("peer", "GetFEM", f"{t:g}") for t in GETFEM]
    return found
