"""Figures 4-7: traction and dissipated energy density along the surface, for four loads and two gradings."""

import numpy as np

from ...output.style import COLOURS, MARKERS, panels
from .elements import Deviation, Runs, closed_field, convert
from .setting import EXPONENTS, MU, NU, SHARES, contact, homogeneous_units, own_units

NOTE = (
    f"Lines: closed forms with ν = {NU:g} (the paper gives no ν; μ drops out), which neglect coupling. "
    "The loads are our choice: the paper names none.\n"
    "Points: finite elements with coupling off, the node farthest from its curve among them. "
    r"Dotted: half-width $a_0$ of the homogeneous contact; $p_0 = 2P/(\pi a_0)$."
)
QUANTITIES = {
    "traction": r"traction $q\,/\,(\mu p_0)$ [–]",
    "density": r"energy density $w\,R\,/\,(\mu^2 P a_0)$ [–]",
}
NAMES = {"traction": "Tangential traction", "density": "Energy dissipated per cycle and area"}


def curve(k: float, y0_over_a0: float, share: float, quantity: str, x) -> np.ndarray:
    """Closed form (47) or (51) at x/a0, shape of x, in the figures' units; share = Q/(mu P)."""
    normal = contact(k, y0_over_a0, NU)
    loop = normal.fretting(MU, z=1 - share)
    values = loop.amplitude.traction(x) if quantity == "traction" else loop.energy_density(x)
    # beside the contact h_x is the free surface's and q is zero
    return values / getattr(homogeneous_units(normal), quantity)


def draw(runs: Runs, number: int, y0_over_a0: float, quantity: str):
    """Figure ``number`` with its deviations; quantity: 'traction' or 'density'."""
    figure, axes = panels(2, f"Figure {number}. {NAMES[quantity]}, $y_0 = {y0_over_a0:g}\\,a_0$", NOTE)
    deviations = []
    for axis, (panel, k) in zip(axes[0], EXPONENTS.items(), strict=True):
        deviations += _panel(axis, runs, panel, k, y0_over_a0, quantity)
    for axis in axes[0]:
        axis.set_ylim(0, 1.25 * axis.get_ylim()[1])  # room for the legend
    return figure, deviations


def _panel(axis, runs, panel, k, y0_over_a0, quantity):
    normal = contact(k, y0_over_a0)
    own, units = own_units(normal), homogeneous_units(normal)
    reach = 1.15 * normal.a
    x = np.unique(np.concatenate([np.linspace(-reach, reach, 801), normal.a * (1 - np.geomspace(1e-8, 0.1, 60))]))
    deviations = []
    for share, field in runs.monotone(k).items():
        i = SHARES.index(share)
        axis.plot(x, curve(k, y0_over_a0, share, quantity, x), color=COLOURS[i])
        computed = convert(getattr(field, quantity), own, units, quantity)
        closed = closed_field(normal, normal.fretting(MU, z=1 - share), field.x, share * MU * normal.P, "initial")
        exact = closed["traction"] if quantity == "traction" else 4 * closed["traction"] * closed["slip"]
        name = f"k = {k:g}, Q = {share:g} μP"
        found = Deviation.of(panel, name, quantity, True, field.weight, getattr(field, quantity), exact)
        deviations.append(found)
        place, drawn = convert(field.x, own, units, "length"), field.drawn(found.at)
        if quantity == "density":  # the stick zone's zeros would lie on one another
            drawn = drawn[computed[drawn] > 1e-6 * computed.max()]
        label = rf"$Q = {share:g}\,\mu P$" if quantity == "traction" else rf"$Q_A = {share:g}\,\mu P$"
        axis.plot(place[drawn], computed[drawn], MARKERS[i], color=COLOURS[i], label=label)
    axis.axvline(-1, color="0.6", lw=1, ls=":")
    axis.axvline(1, color="0.6", lw=1, ls=":")
    axis.set(xlabel=r"position $x/a_0$ [–]", ylabel=QUANTITIES[quantity], title=f"({panel})  $k = {k:g}$")
    axis.legend(loc="upper center", ncols=2)
    return deviations
