"""Map of the critical coefficient of friction of surface elements over k and ν.

    python -m simulations.studies.critical_friction [--output DIR] [--values K NU]

Some seconds on one core. docs/critical_friction.md says what the bounds are bounds of.
"""

import numpy as np

from ..command.command import comm, on_root, run, say
from ..output.files import write_table
from ..output.style import BLACK, RED, panels, save, style
from ..runs.critical_friction import of_half_plane
from .commandline import read_map

K, NU = (-0.8, 0.8), (0.0, 0.5)
LEVELS = (0.25, 0.5, 1.0, 1.5, 2.0, 3.0, 5.0, 10.0, 30.0)
PANELS = {"lower": "unique for every pattern below", "upper": "not unique from here on, for some pattern"}


def main(arguments: list[str]):
    """Fill the table, then draw it; on rank 0."""
    given = on_root(lambda: read_map(arguments, "critical_friction", __doc__, (17, 11)))
    if comm.rank:
        return
    k, nu = (np.linspace(*ends, count) for ends, count in zip((K, NU), given.values, strict=True))
    rows = [row(a, b) for a in k for b in nu]
    write_table(given.output / "critical_friction.csv", rows)
    _draw(given.output, rows, k, nu)
    say(f"figure and table in {given.output}")


def row(k: float, nu: float) -> dict:
    """Both bounds at k and ν, and the pattern of the upper one."""
    return {"k": f"{k:.6g}", "nu": f"{nu:.6g}"} | vars(of_half_plane(k, nu))


def _draw(folder, rows, k, nu):
    note = "12 equal elements on the half-plane; dashed: Holl ratio, where there is no coupling and no bound"
    with style():
        figure, axes = panels(2, "Critical coefficient of friction [–]", note)
        for axis, (name, title) in zip(axes[0], PANELS.items(), strict=True):
            values = np.array([found[name] for found in rows]).reshape(len(k), len(nu)).T
            values = np.clip(values, LEVELS[0] / 2, LEVELS[-1] * 2)
            axis.contourf(k, nu, np.log(values), levels=np.log(LEVELS), cmap="cividis", extend="both")
            lines = axis.contour(k, nu, np.log(values), levels=np.log(LEVELS), colors=BLACK, linewidths=0.8)
            labels = axis.clabel(lines, fmt={np.log(level): f"{level:g}" for level in LEVELS}, fontsize=9)
            for label in labels:
                label.set_bbox({"facecolor": "white", "alpha": 0.8, "pad": 1, "edgecolor": "none"})
            holl = np.linspace(0, K[1], 50)
            axis.plot(holl, 1 / (2 + holl), color=RED, ls="--", lw=2)
            axis.set(title=title, xlabel="exponent k [–]", ylabel="Poisson's ratio ν [–]", xlim=K, ylim=NU)
            axis.grid(False)
        save(figure, folder, "critical_friction")


if __name__ == "__main__":
    run(main)
