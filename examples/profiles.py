"""Which indenter loses most energy? Three profiles and two gradings, run from Python; a picture of their tractions.

    python examples/profiles.py [PICTURE.png]
"""

import sys

import matplotlib.pyplot as plt

from simulations import Result, run

PROFILES = {
    "parabola": {},
    "x^4": {"indenter.profile": "power", "indenter.exponent": 4},
    "cosh": {"indenter.profile": "formula", "indenter.formula": "R*(cosh(x/R) - 1)"},
}
GRADINGS = {"k = 0": 0.0, "k = 0.3": 0.3}
# a coarse mesh and few increments: about a per cent, a second a run
QUICK = {"mesh.facet": 0.05, "mesh.edge_facet": 0.01, "mesh.growth": 1.5, "mesh.first_layer": 0.01}
# y0 in metres: 10 a0, as in the default scene, would be another solid under each profile
COMMON = {"solid.y0": 7.5e-3, "effects.coupling": False, "load.amplitude": 0.7, "solver.increments": 2}
STYLES = {"parabola": "-", "x^4": ".-", "cosh": "."}  # the last lies on the first


def results() -> dict[tuple[str, str], Result]:
    """A run for every profile and grading, at the Holl ratio."""
    return {
        (profile, grading): run(COMMON | QUICK | keys | {"solid.k": k})
        for profile, keys in PROFILES.items()
        for grading, k in GRADINGS.items()
    }


def main(picture: str = "profiles.png"):
    """The table on standard output and the picture."""
    figure, axes = plt.subplots(1, len(GRADINGS), figsize=(9, 4), sharey=True, layout="constrained")
    for (profile, grading), result in results().items():
        print(f"{profile:10s} {grading:8s} a = {1e3 * result.a:.3f} mm   {result.dissipated_energy:.4f} J/m a cycle")
        axis = axes[list(GRADINGS).index(grading)]
        axis.plot(1e3 * result.x, 1e-6 * result.traction[-1], STYLES[profile], label=profile)
        axis.set(title=grading, xlabel="position x [mm]")
    axes[0].set_ylabel("traction q [MPa]")
    axes[0].legend()
    figure.savefig(picture, dpi=120)


if __name__ == "__main__":
    main(*sys.argv[1:2])
