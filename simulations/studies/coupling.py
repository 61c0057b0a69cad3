"""How much the coupling of normal and tangential contact changes a fretting loop, over k, ν and μ.

    mpirun -n 2 python -m simulations.studies.coupling [--output DIR] [--values K NU]

Every loop is computed by the half-plane solver without load steps, with coupling and without: frictionless pressing,
then Q_A = 0.9 μP. The ranks share the loops; a study that was stopped goes on where it was.
"""

import matplotlib.pyplot as plt
import numpy as np
from scipy.interpolate import RectBivariateSpline

from analytic import CoupledLoop, GradedHalfPlane, PowerProfile
from analytic.coupled.rule import smooth_rule

from ..command.command import comm, on_root, run, say
from ..output.files import write_table
from ..output.style import RED, save, style
from ..runs.comparison import relative_l2
from .commandline import read_map
from .engine import FAILED, Item, Row, run_on
from .store import Store

FRICTION, AMPLITUDE = (0.1, 0.3, 0.6), 0.9
K, NU = (-0.5, 0.7), (0.0, 0.5)
COLUMNS = ("k", "nu", "mu", "pressure", "traction", "slip", "energy")
SHOWN = dict(zip(COLUMNS[3:], ("pressure", "traction", r"slip between $\pm Q_A$", "energy per cycle")))
ORDER = {"pressure": 1, "traction": 1, "slip": 2, "energy": 2}  # with which they vanish with the coupling
NOISE = 0.002  # power of the coupling below which the loops' own error rules their difference
LEVELS = (0.1, 0.3, 1.0, 3.0, 10.0, 30.0, 100.0)  # per cent


def main(arguments: list[str]):
    """Fill the table, then draw it."""
    given = on_root(lambda: read_map(arguments, "coupling", __doc__, (13, 6)))
    k, nu = (np.linspace(*ends, count) for ends, count in zip((K, NU), given.values, strict=True))
    points = [_point(a, b, mu) for mu in FRICTION for a in k for b in nu]
    items = [Item(f"k = {a:g}, nu = {b:g}, mu = {mu:g}", {"k": a, "nu": b, "mu": mu}) for a, b, mu in points]
    rows = run_on(comm, items, _row, Store(given.output / "loops.jsonl"), say)
    if rows is None:
        return
    missing = dict.fromkeys(SHOWN, np.nan)
    found = {p: missing if FAILED in row else row for p, row in zip(points, rows, strict=True)}
    table = [dict(zip(COLUMNS, [*p, *(f"{row[name]:.6g}" for name in SHOWN)])) for p, row in found.items()]
    write_table(given.output / "coupling.csv", table)
    _draw(given.output, found, k, nu)
    say(f"figure and table in {given.output}")


def changes(k: float, nu: float, mu: float) -> dict[str, float]:
    """Relative changes by coupling, after one cycle: L2 of p and q at +Q_A, and of the way slipped between ±Q_A."""
    solid, loads = GradedHalfPlane(1.0, nu, k, 1.0), [(1.0, AMPLITUDE * mu * share) for share in (0, 1, -1, 1)]
    coupled, alone = (
        CoupledLoop(solid, PowerProfile(0.5, 2.0), 1.0, mu, coupling).run(loads) for coupling in (True, False)
    )
    # where tractions are not smooth: they remember where each turn of Q left the edge of stick
    edges = [edge for states in (coupled, alone) for state in states[1:] for edge in (*state.contact, *state.stick)]
    x, weight = smooth_rule(min(edges), max(edges), edges)
    left, right = np.transpose([state.contact for states in (coupled, alone) for state in states[-2:]])
    common = np.where((x > left.max()) & (x < right.min()), weight, 0.0)  # with and without, at both ends of the way
    result = {
        name: relative_l2(common if name == "slip" else weight, field(x, coupled), field(x, alone))
        for name, field in FIELDS.items()
    }
    cycle = [states[-1].dissipated_energy - states[1].dissipated_energy for states in (coupled, alone)]
    return result | {"energy": cycle[0] / cycle[1] - 1}


FIELDS = {
    "pressure": lambda x, states: states[-1].pressure_at(x),
    "traction": lambda x, states: states[-1].traction_at(x),
    "slip": lambda x, states: states[-1].slip_at(x) - states[-2].slip_at(x),
}


def _point(k, nu, mu) -> tuple[float, float, float]:
    return round(float(k), 6), round(float(nu), 6), round(float(mu), 6)


def _row(values: Row) -> Row:
    return changes(values["k"], values["nu"], values["mu"])


def _interpolated(rows, name, mu, k, nu, fine_k, fine_nu):
    """|change| in per cent on a finer grid: smooth over a power of the coupling, which is zero at the Holl ratio."""

    def strength(a, b):
        solid = GradedHalfPlane(1.0, b, a, 1.0)
        return abs(solid.d / solid.bk) ** ORDER[name]

    ratio = np.array([[rows[_point(a, b, mu)][name] / (strength(a, b) or np.nan) for b in nu] for a in k])
    ratio[np.array([[strength(a, b) for b in nu] for a in k]) < NOISE] = np.nan
    known = ~np.isnan(ratio).all(axis=0)  # columns with a loop that did not fail
    if known.sum() < 2:
        return np.full((len(fine_nu), len(fine_k)), np.nan)
    nu, ratio = nu[known], ratio[:, known]
    for column in ratio.T:  # at the Holl ratio, and where a loop failed: between its neighbours
        hole = np.isnan(column)
        column[hole] = np.interp(k[hole], k[~hole], column[~hole])
    smooth = RectBivariateSpline(k, nu, ratio, kx=1, ky=1)(fine_k, fine_nu)
    return 100 * np.abs(smooth * [[strength(a, b) for b in fine_nu] for a in fine_k]).T


def _draw(folder, rows, k, nu):
    holl, fine_k, fine_nu = np.linspace(0, K[1], 101), np.linspace(*K, 121), np.linspace(*NU, 101)
    with style():
        shape = len(FRICTION), len(SHOWN)
        figure, axes = plt.subplots(*shape, figsize=(13, 9), sharex=True, sharey=True, layout="constrained")
        for line, mu in zip(axes, FRICTION, strict=True):
            for axis, name in zip(line, SHOWN, strict=True):
                share = _interpolated(rows, name, mu, k, nu, fine_k, fine_nu)
                share = np.clip(share, 1.01 * LEVELS[0], 0.99 * LEVELS[-1])
                filled = axis.contourf(fine_k, fine_nu, np.log10(share), levels=np.log10(LEVELS), cmap="cividis")
                axis.contour(fine_k, fine_nu, np.log10(share), levels=[0.0], colors="white", linewidths=1.5)
                axis.plot(holl, 1 / (2 + holl), color=RED, lw=2, ls="--")
                axis.set(xlim=K, ylim=NU)
                axis.grid(False)
        for axis, name in zip(axes[0], SHOWN.values(), strict=True):
            axis.set_title(f"change of {name}")
        for axis, mu in zip(axes[:, 0], FRICTION, strict=True):
            axis.set_ylabel(f"μ = {mu:g}\nPoisson's ratio ν [–]")
        for axis in axes[-1]:
            axis.set_xlabel("exponent k [–]")
        figure.suptitle(f"Loops of amplitude $Q_A$ = {AMPLITUDE:g} μP, pressed without friction", fontsize=13)
        bar = figure.colorbar(filled, ax=axes, ticks=np.log10(LEVELS), pad=0.02, aspect=40)
        bar.ax.set_yticklabels([f"{level:g}" for level in LEVELS])
        bar.set_label("relative change by coupling [%]   (white line: 1 %, dashed: ν = 1/(2+k))")
        save(figure, folder, "coupling", ("png", "svg"))


if __name__ == "__main__":
    run(main)
