"""Sentences of Sections 4 and 5 on the cycle and on coupling: how large the difference to the closed forms is."""

from itertools import pairwise
from typing import NamedTuple

import numpy as np

from analytic import ContactNotConverged, CoupledLoop, PowerProfile
from analytic.coupled.rule import smooth_rule
from analytic.coupled.state import CoupledState

from ...runs.comparison import relative_l2
from ..engine import FAILED, Item, run_on
from .claim import Claim, minus_signs, verdict
from .comparisons import COUPLED, DEPTH, HOLL, NEGATIVE, slip_at_A, theory, traction_at
from .elements import Runs
from .setting import AMPLITUDE, MU, STATES, contact

AGREES_WELL = 0.05  # relative difference up to which a field counts as agreeing well
PARABOLA = PowerProfile(0.5, 2)  # f = x²/(2R) with R = 1
STEPS = 2001  # of the load, for the integral over a cycle
TABLE_K = (-0.5, -0.3, -0.1, 0.0, 0.3, 0.5)
TABLE_NU = (0.0, 0.1, 0.2, 0.3, 0.4, 0.45, 0.495)
TURNS = (0.0, 1.0, -1.0, 1.0, -1.0, 1.0)  # Q over Q_A: two cycles


class Difference(NamedTuple):
    """A coupled loop beside the closed forms: relative L2 of traction and slip at the first +Q_A; energy, signed.

    nan where the simulation does not converge.
    """

    traction: float = np.nan
    slip: float = np.nan
    energy: float = np.nan

    def in_per_cent(self) -> str:
        """Slip, traction and energy in words."""
        return f"{self.slip:.1%} / {self.traction:.1%} / {self.energy:+.1%}"


def simulated(k: float, nu: float, mu: float = MU) -> list[CoupledState]:
    """States at the TURNS of the loop of amplitude AMPLITUDE, in units of a0, y0 = DEPTH."""
    normal = contact(k, DEPTH, nu)
    loop = CoupledLoop(normal.solid, PARABOLA, normal.P, mu)
    return loop.run([(normal.P, AMPLITUDE * mu * normal.P * share) for share in TURNS])


def difference(k: float, nu: float, mu: float = MU) -> Difference:
    """That of the loop of amplitude AMPLITUDE."""
    normal = contact(k, DEPTH, nu)
    loop = normal.fretting(mu, z=1 - AMPLITUDE)
    try:
        states = simulated(k, nu, mu)
        energy = states[-1].dissipated_energy - states[-3].dissipated_energy
    except ContactNotConverged:
        return Difference()
    state = states[1]
    edges = [*state.contact, *state.stick, -loop.a, -loop.c, loop.c, loop.a]
    x, weight = smooth_rule(min(edges), max(edges), edges)
    under = np.where(np.abs(x) < loop.a, weight, 0.0)
    return Difference(
        traction=relative_l2(weight, state.traction_at(x), loop.amplitude.traction(x)),
        slip=relative_l2(under, -state.slip_at(x), loop.amplitude.slip(x)),
        energy=energy / loop.dissipated_energy - 1,
    )


def differences(comm) -> dict[tuple[float, float], Difference]:
    """The table by k and nu, on every rank."""
    items = [Item(f"k = {k:g}, nu = {nu:g}", {"k": k, "nu": nu}) for k in TABLE_K for nu in TABLE_NU]
    rows = comm.bcast(run_on(comm, items, _difference_row))
    failed = [row[FAILED] for row in rows if FAILED in row]
    if failed:
        raise RuntimeError(failed[0])
    return {(item.values["k"], item.values["nu"]): Difference(**row) for item, row in zip(items, rows, strict=True)}


def _difference_row(values: dict) -> dict:
    return difference(**values)._asdict()


def difference_table(found: dict[tuple[float, float], Difference]) -> str:
    """Markdown: rows k, columns nu, each cell slip / traction / energy in per cent."""
    text = "| k, ν | " + " | ".join(f"{nu:g}" for nu in TABLE_NU) + " |\n|---|" + "---|" * len(TABLE_NU) + "\n"
    for k in TABLE_K:
        row = [found[k, nu] for nu in TABLE_NU]
        cells = ["–" if np.isnan(one.slip) else one.in_per_cent() for one in row]
        text += f"| {k:g} | " + " | ".join(cells) + " |\n"
    return minus_signs(text.replace("%", ""))


def cycle_claims() -> list[Claim]:
    """What happens through the cycle, by the closed forms [X5] and the half-plane solver."""
    return [rectangle(), memory(), inward(), mirrored()]


def rectangle() -> Claim:
    """Work of q on the slip through the closed cycle [X5], summed up in small steps, against 4 q h_x."""
    worst = 0.0
    for pair in (NEGATIVE, HOLL):
        normal, loop = theory(pair)
        x = normal.a * np.linspace(0.0, 0.999, 200)[:, None]
        Q = np.linspace(loop.Q_A, -loop.Q_A, STEPS)
        q, h = loop.traction(x, Q, "unloading"), loop.slip(x, Q, "unloading")
        half = np.trapezoid(q, h, axis=1)  # reloading repeats it, signs turned
        closed = loop.energy_density(x[:, 0])
        worst = max(worst, float(np.max(np.abs(2 * half - closed)) / closed.max()))
    return Claim(
        "5.2, (51)",
        "The hysteresis loop of traction and displacement is a rectangle: w = 4 q h_x",
        f"∮ q dh_x in {STEPS - 1} steps of the load, k = −0.1 and 0.3: within {worst:.0e} of the peak of w",
        verdict(worst < 1e-3),
    )


def memory() -> Claim:
    """Residual traction at C."""
    left = {}
    for pair in (NEGATIVE, HOLL):
        normal, loop = theory(pair)
        x = np.linspace(-normal.a, normal.a, 2001)
        left[pair.k] = float(np.max(np.abs(loop.traction(x, 0.0, "unloading"))) / (MU * normal.peak_pressure))
    return Claim(
        "5.3, Fig. 11",
        "In state C the tangential load vanishes, yet the material remembers the loading",
        f"largest traction there: {left[-0.1]:.2f} μp(0) for k = −0.1, {left[0.3]:.2f} μp(0) for k = 0.3",
        verdict(min(left.values()) > 0.1),
    )


def inward() -> Claim:
    """d/a at the states."""
    found = {}
    for pair in (NEGATIVE, HOLL):
        _, loop = theory(pair)
        widths = [loop.active_half_width(share * loop.Q_A, branch) / loop.a for share, branch in STATES.values()]
        found[pair.k] = [float(w) for w in widths]
    text = "; ".join(f"k = {k:g}: {', '.join(f'{w:.3f}' for w in widths)}" for k, widths in found.items())
    return Claim(
        "5.3, Fig. 11",
        "As the load is reduced reverse slip starts at the edges and propagates inward",
        f"half-width d/a of the zone without reverse slip in A, B, C, D, E: {text}",
        verdict(all(a > b for widths in found.values() for a, b in pairwise(widths))),
    )


def mirrored() -> Claim:
    """q_E against -q_A; with coupling the mirror is that of x as well."""
    turns = simulated(NEGATIVE.k, NEGATIVE.nu)[1:]
    start, end = turns[-3:-1]
    edges = [way * edge for state in turns for edge in (*state.contact, *state.stick) for way in (1, -1)]
    x, weight = smooth_rule(min(edges), max(edges), edges)
    plain, turned = (relative_l2(weight, -end.traction_at(way * x), start.traction_at(x)) for way in (1, -1))
    return Claim(
        "5.3, Fig. 11",
        "In state E the traction is that of state A mirrored",
        f"exactly q_E = −q_A without coupling; with it q_E(x) = −q_A(−x) (k = −0.1, ν = 0.495: L2 {turned:.1%}; "
        f"without turning x {plain:.1%})",
        verdict(turned < 0.01 and plain < 0.01, turned < 0.01),
    )


def coupling_claims(runs: Runs, found: dict[tuple[float, float], Difference]) -> list[Claim]:
    """Section 5.3 and the assumption of Section 4, by finite elements and by the half-plane solver."""
    slip = {pair: slip_at_A(runs, pair)[-1].l2 for pair in (NEGATIVE, HOLL, COUPLED)}
    states = {pair: {name: traction_at(runs, pair, name)[-1].l2 for name in STATES} for pair in (NEGATIVE, HOLL)}
    negative, coupled = found[NEGATIVE.k, NEGATIVE.nu], found[COUPLED.k, COUPLED.nu]
    low, high = min(states[NEGATIVE].values()), max(states[NEGATIVE].values())
    known = {place: one for place, one in found.items() if not np.isnan(one.slip)}
    small = [one for one in known.values() if max(one.slip, one.traction, abs(one.energy)) <= AGREES_WELL]
    k, nu = max(known, key=lambda place: known[place].slip)
    return [
        Claim(
            "4",
            "The coupling effects are often so small that they can be neglected",
            f"slip, traction and energy all within {AGREES_WELL:.0%} at {len(small)} of the {len(known)} points below; "
            f"at k = {k:g}, ν = {nu:g} slip is off by {known[k, nu].slip:.0%}, energy by {known[k, nu].energy:+.0%}",
            verdict(len(small) == len(known), bool(small)),
        ),
        Claim(
            "5.3, Fig. 10a",
            "k = −0.1, ν = 0.495: results agree well; coupling can be neglected in this case",
            f"slip: L2 difference {slip[NEGATIVE]:.1%} (half-plane {negative.slip:.1%}), "
            f"traction {negative.traction:.1%}, energy {negative.energy:+.1%}",
            verdict(max(slip[NEGATIVE], negative.traction, abs(negative.energy)) <= AGREES_WELL),
        ),
        Claim(
            "5.3, Fig. 10b",
            "k = 0.3 at the Holl ratio: the results fit very well",
            f"slip: L2 error {slip[HOLL]:.0e}",
            verdict(slip[HOLL] < 1e-3),
        ),
        Claim(
            "5.3, Fig. 10b",
            "k = 0.3, ν = 0.3: only marginal deviations due to coupling",
            f"slip: L2 difference {slip[COUPLED]:.1%} (half-plane {coupled.slip:.1%}), "
            f"traction {coupled.traction:.1%}, energy {coupled.energy:+.1%}",
            verdict(max(slip[COUPLED], coupled.traction, abs(coupled.energy)) <= AGREES_WELL),
        ),
        Claim(
            "5.3, Fig. 11a",
            "k = −0.1, ν = 0.495: traction shows only minor deviations",
            "L2 difference " + ", ".join(f"{state} {d:.1%}" for state, d in states[NEGATIVE].items()),
            verdict(high <= AGREES_WELL, low <= AGREES_WELL),
        ),
        Claim(
            "5.3, Fig. 11b",
            "k = 0.3 at the Holl ratio: traction matches very well",
            "L2 error " + ", ".join(f"{state} {d:.0e}" for state, d in states[HOLL].items()),
            verdict(max(states[HOLL].values()) < 1e-2),
        ),
    ]
