"""Figures 10 and 11: slip and traction of the paper's own pairs of k and nu, coupled finite elements on the theory."""

from dataclasses import dataclass

import numpy as np

from analytic import GradedHalfPlane

from ...output.style import BLACK, BLUE, COLOURS, MARKERS, RED, panels
from .elements import Deviation, Runs, closed_field, convert
from .setting import AMPLITUDE, MU, STATES, contact, homogeneous_units, own_units

DEPTH = 10.0  # y0/a0
LOADS = {"A": "$+Q_A$", "B": "$+Q_A/2$", "C": "0", "D": "$-Q_A/2$", "E": "$-Q_A$"}


@dataclass(frozen=True)
class Pair:
    """Exponent and Poisson's ratio; at the Holl ratio the closed forms are exact."""

    k: float
    nu: float

    @property
    def is_decoupled(self) -> bool:
        """True at the Holl ratio 1/(2+k)."""
        return abs(self.nu * (2 + self.k) - 1) < 1e-9

    @property
    def name(self) -> str:
        """For tables."""
        return f"k = {self.k:g}, ν = {self.nu:.5g}"

    @property
    def label(self) -> str:
        """The same, set as mathematics."""
        return rf"$k = {self.k:g}$, $\nu = {self.nu:.5g}$"


NEGATIVE = Pair(-0.1, 0.495)
HOLL = Pair(0.3, GradedHalfPlane.holl_ratio(0.3))  # the paper's 0.43478
COUPLED = Pair(0.3, 0.3)
NOTE = (
    f"Lines: closed forms, exact at the Holl ratio ν = 1/(2+k) alone. Points: finite elements with coupling, the node "
    f"farthest from each curve among them.\nμ = {MU:g}, which the paper does not give. "
)
RING = {"mfc": "none", "mec": BLACK, "ms": 13, "mew": 1.4, "ls": "none"}


def theory(pair: Pair):
    """Normal contact and loop of a pair in units of a0."""
    normal = contact(pair.k, DEPTH, pair.nu)
    return normal, normal.fretting(MU, z=1 - AMPLITUDE)


def slip_at_A(runs: Runs, pair: Pair, panel: str = ""):
    """Computed field at A, its nodes in contact (n,), and how far its slip there is from the theory."""
    normal, loop = theory(pair)
    field = runs.loop(pair.k, pair.nu, AMPLITUDE, coupling=True).states["A"]
    under = np.flatnonzero(np.abs(field.x) <= 1)
    closed = closed_field(normal, loop, field.x[under], loop.Q_A, "unloading")["slip"]
    values = field.weight[under], -field.slip[under], closed
    return field, under, Deviation.of(panel, pair.name, "slip", pair.is_decoupled, *values)


def traction_at(runs: Runs, pair: Pair, state: str, panel: str = ""):
    """Computed field at one of the STATES, and how far its traction is from the theory."""
    normal, loop = theory(pair)
    share, branch = STATES[state]
    field = runs.loop(pair.k, pair.nu, AMPLITUDE, coupling=True).states[state]
    closed = closed_field(normal, loop, field.x, share * loop.Q_A, branch)["traction"]
    name, values = f"{pair.name}, {state}", (field.weight, field.traction, closed)
    return field, Deviation.of(panel, name, "traction", pair.is_decoupled, *values)


def figure10(runs: Runs):
    """Slip at +Q_A, where the paper's (50) holds."""
    note = (
        NOTE
        + rf"State A, the end of the first loading, $Q_A = {AMPLITUDE:g}\,\mu P$ as in Figure 11; "
        + rf"$y_0 = {DEPTH:g}\,a_0$."
    )
    figure, axes = panels(2, "Figure 10. Relative tangential displacement (slip)", note)
    deviations = []
    panels_ = {"a": {NEGATIVE: (BLUE, "o")}, "b": {HOLL: (RED, "o"), COUPLED: (BLUE, "s")}}
    for axis, (panel, curves) in zip(axes[0], panels_.items(), strict=True):
        for pair, (colour, marker) in curves.items():
            normal, loop = theory(pair)
            own, units = own_units(normal), homogeneous_units(normal)
            x = np.linspace(-normal.a, normal.a, 601)
            axis.plot(x, loop.amplitude.slip(x) / units.slip, color=colour)
            field, under, found = slip_at_A(runs, pair, panel)
            slip, place = convert(-field.slip, own, units, "slip"), convert(field.x, own, units, "length")
            deviations.append(found)
            drawn = [i for i in field.drawn(under[found.at]) if field.pressure[i] > 0]
            label = pair.label + (" (Holl ratio)" if pair.is_decoupled else "")
            axis.plot(place[drawn], slip[drawn], marker, color=colour, label=label)
        axis.set(
            xlabel=r"position $x/a_0$ [–]",
            ylabel=r"slip $h_x\,/\,(\mu a_0^2/2R)$ [–]",
            title=f"({panel})  $k = {next(iter(curves)).k:g}$",
        )
        axis.legend(loc="upper center")
    return figure, deviations


def figure11(runs: Runs):
    """Traction at the states A ... E."""
    note = (
        NOTE
        + "It does not give the loads of B and D either.\n"
        + rf"$Q_A = {AMPLITUDE:g}\,\mu P$, $y_0 = {DEPTH:g}\,a_0$; $p_0 = 2P/(\pi a_0)$ and $a_0$: peak pressure and "
        + "half-width of the homogeneous contact."
    )
    figure, axes = panels(2, "Figure 11. Tangential traction through the cycle", note)
    deviations = []
    for axis, (panel, pair) in zip(axes[0], {"a": NEGATIVE, "b": HOLL}.items(), strict=True):
        deviations += traction_panel(axis, runs, panel, pair)
        axis.legend(loc="upper center", ncols=3, columnspacing=1.0, handletextpad=0.3)
        axis.set_ylim(-1.3, 1.95)
    return figure, deviations


def traction_panel(axis, runs: Runs, panel: str, pair: Pair):
    """One panel of Figure 11 for any pair, with a ring around the node farthest from its curve; its deviations."""
    normal, loop = theory(pair)
    own, units = own_units(normal), homogeneous_units(normal)
    x = np.linspace(-1.15, 1.15, 1201) * normal.a
    farthest = {}
    for i, (state, (share, branch)) in enumerate(STATES.items()):
        axis.plot(x, loop.traction(x, share * loop.Q_A, branch) / units.traction, color=COLOURS[i])
        field, found = traction_at(runs, pair, state, panel)
        traction, place = convert(field.traction, own, units, "traction"), convert(field.x, own, units, "length")
        drawn, label = field.drawn(found.at), f"{state}: " + LOADS[state]
        axis.plot(place[drawn], traction[drawn], MARKERS[i], ms=4, color=COLOURS[i], label=label)
        farthest[found] = place[found.at], traction[found.at]
    worst = max(farthest, key=lambda found: found.largest)
    axis.plot(*farthest[worst], "o", label=f"{worst.kind} {100 * worst.largest:.2g} %", **RING)
    axis.set(xlabel=r"position $x/a_0$ [–]", ylabel=r"traction $q\,/\,(\mu p_0)$ [–]", title=f"({panel})  {pair.label}")
    return list(farthest)
