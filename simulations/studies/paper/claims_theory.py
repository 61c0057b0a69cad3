"""Sentences of Section 5 that the closed forms decide: Figures 4-9 and the homogeneous limit."""

import numpy as np
from scipy.integrate import quad
from scipy.optimize import minimize_scalar

from .claim import FAILS, UNCHECKED, Claim, verdict
from .energies import curve
from .setting import DEPTHS, GRADINGS, MU, NU, SHARES, contact, load

RATIOS = (0.0, 0.1, 0.2, 0.3, 0.4, 0.5)  # of Poisson, over which a statement is tried
AMPLITUDES = np.linspace(0.05, 0.95, 19)
ALL_K = np.linspace(-0.95, 0.95, 39)
THIN, THICK = 0.01, 10.0  # y0/a0 of Figure 9


def theory_claims() -> list[Claim]:
    """Every such claim, in the paper's order."""
    larger = "For y0 = 0.1 a0 the half-width is larger than the homogeneous one for k = −0.5, smaller for k = 0.5"
    stiff = "ΔW of a material very stiff up to a small depth is much greater than in the homogeneous medium"
    deep = "Large values also occur at high exponents with high characteristic depths"
    fleury = "The homogeneous curves correspond exactly to values of Fleury et al. [38]"
    return [
        overlap(),
        half_widths("5.1, Fig. 4", larger, 0.1, negative_larger=True),
        half_widths("5.1, Fig. 5", "For y0 = 10 a0 the opposite", 10.0, negative_larger=False),
        slopes(),
        maxima(),
        against_depth("a", -0.5, "Negative grading: ΔW increases with decreasing characteristic depth", -1),
        against_depth("b", 0.5, "Positive grading: ΔW increases with increasing characteristic depth", 1),
        thin_exponents(),
        thick_exponents(),
        much_greater(stiff, -0.5, THIN),
        much_greater(deep, 0.5, THICK),
        softer(),
        homogeneous_limit(),
        homogeneous_integral(),
        Claim("5.2", fleury, "no data here", UNCHECKED),
    ]


def overlap() -> Claim:
    """q = mu p where it slides."""
    worst = 0.0
    for k in (-0.5, 0.5):
        normal = contact(k, 0.1)
        for share in SHARES:
            slip = normal.partial_slip(MU, z=1 - share)
            x = np.linspace(slip.c * (1 + 1e-12), normal.a, 200)
            limit = MU * normal.pressure(x)
            worst = max(worst, float(np.max(np.abs(slip.traction(x) - limit)) / (MU * normal.peak_pressure)))
    return Claim(
        "5.1, Figs. 4, 5",
        "In the sliding regions the curves overlap: tractions proportional to the normal stresses",
        f"largest \\|q − μp\\| there: {worst:.1g} μp(0)",
        verdict(worst < 1e-12),
    )


def half_widths(place, sentence, depth, negative_larger) -> Claim:
    """Which of k = -0.5 and 0.5 has a wider contact than the homogeneous half-plane."""
    negative, positive = ([contact(k, depth, nu).a / contact(k, depth, nu).a0 for nu in RATIOS] for k in (-0.5, 0.5))
    larger, smaller = (negative, positive) if negative_larger else (positive, negative)
    at = RATIOS.index(NU)
    text = f"a/a0 = {negative[at]:.3f} for k = −0.5, {positive[at]:.3f} for k = 0.5; "
    text += "the same order for all ν from 0 to 0.5"
    return Claim(place, sentence, text, verdict(min(larger) > 1 > max(smaller)))


def slopes() -> Claim:
    """|dq/dx| in the slip zone, per mu p(0)/a, at Q = 0.8 mu P."""

    def slope(k, x):
        return (1 + k) * x * (1 - x * x) ** ((k - 1) / 2)

    at = {}
    for k in (-0.5, 0.5):
        c = 0.2 ** (1 / (2 + k))
        at[k] = slope(k, c), slope(k, 0.99)
    small = at[-0.5][0] < at[0.5][0]
    growth = {k: end / start for k, (start, end) in at.items()}
    return Claim(
        "5.1, Figs. 4, 5",
        "For negative k the slope of the tractions is relatively small near the stick zone, very large near the edge",
        f"at Q = 0.8 μP, in μp(0)/a: k = −0.5: {at[-0.5][0]:.2f} beside c, {at[-0.5][1]:.1f} at 0.99 a "
        f"(× {growth[-0.5]:.0f}); k = 0.5: {at[0.5][0]:.2f} and {at[0.5][1]:.1f} (× {growth[0.5]:.1f})",
        verdict(small and growth[-0.5] > 10 * growth[0.5]),
    )


def position_of_maximum(k: float, y0_over_a0: float, share: float) -> float:
    """x/a at which w is largest for Q_A = share mu P."""
    loop = contact(k, y0_over_a0).fretting(MU, z=1 - share)
    found = minimize_scalar(lambda x: -loop.energy_density(x), (loop.c, loop.a), (loop.c, loop.a), method="bounded")
    return float(found.x / loop.a)


def maxima() -> Claim:
    """Position of the largest w."""
    at = {k: [position_of_maximum(k, 0.1, share) for share in SHARES] for k in (-0.5, 0.0, 0.5)}
    depth = max(abs(position_of_maximum(-0.5, y, 0.8) - at[-0.5][3]) for y in DEPTHS)
    outward = all(n > h > p for n, h, p in zip(*at.values(), strict=True))
    span = {k: f"{x[3]:.3f}–{x[0]:.3f}" for k, x in at.items()}
    return Claim(
        "5.2, Figs. 6, 7",
        "Regardless of y0 the maxima of w are shifted significantly further toward the edges for negative k",
        f"\\|x\\|/a of the maximum for Q_A = 0.8 … 0.2 μP: k = −0.5: {span[-0.5]}, k = 0: {span[0.0]}, "
        f"k = 0.5: {span[0.5]}; y0 does not move it at all ({depth:.0e})",
        verdict(outward and depth < 1e-4),
    )


def against_depth(panel, k, words, sign) -> Claim:
    """Growth (sign 1) or fall (-1) of ΔW with y0."""
    depths = np.geomspace(1e-3, 1e3, 25)
    energy = np.array([curve(k, y, AMPLITUDES) for y in depths])
    holds = bool(np.all(sign * np.diff(energy, axis=0) > 0))
    power = float(np.log(energy[-1, 9] / energy[0, 9]) / np.log(depths[-1] / depths[0]))
    return Claim(
        f"5.2, Fig. 8{panel}",
        words,
        f"ΔW ∝ (y0)^({power:.3f}) at k = {k:g} for every Q_A (exponent 2k/(2+k))",
        verdict(holds and abs(power - 2 * k / (2 + k)) < 1e-9),
    )


def thin_exponents() -> Claim:
    """Figure 9a: every positive k below every negative one?"""
    energy = {k: float(curve(k, THIN, 0.9)) for k in GRADINGS}
    shown = max(energy[0.25], energy[0.5]) < min(energy[-0.5], energy[-0.25])
    above = [(k, nu) for k in ALL_K if k > 0 for nu in RATIOS if curve(k, THIN, 0.9, nu) > energy[0.0]]
    text = ", ".join(f"{value:.3f}" for value in energy.values())
    text = f"k = −0.5 … 0.5, Q_A = 0.9 μP: {text}"
    if above:
        k, nu = min(above)
        text += f"; but ΔW is not monotone in k: above the homogeneous value from k = {k:.2g} on at ν = {nu:g}"
    return Claim(
        "5.2, Fig. 9a",
        "For very small y0 ΔW is smaller for positive than for negative exponents (y0 = 0.01 a0)",
        text,
        verdict(shown and not above, shown),
    )


def thick_exponents() -> Claim:
    """Figure 9b: monotone in k?"""
    breaks = []
    for nu in RATIOS:
        curves = np.array([curve(k, THICK, AMPLITUDES, nu) for k in ALL_K])
        down = np.any(np.diff(curves, axis=0) <= 0, axis=1)
        breaks += [(ALL_K[i], nu) for i in np.flatnonzero(down)]
    energy = [float(curve(k, THICK, 0.9)) for k in GRADINGS]
    shown = bool(np.all(np.diff(energy) > 0))
    text = f"k = −0.5 … 0.5, Q_A = 0.9 μP: {', '.join(f'{value:.3f}' for value in energy)}; "
    if breaks:
        points = len(ALL_K) * len(RATIOS)
        text += f"falls with k at {len(breaks)} of {points} points (k, ν), first at k = {min(breaks)[0]:.2g}"
    else:
        text += "monotone for −0.95 ≤ k ≤ 0.95 and 0 ≤ ν ≤ 0.5 at every Q_A"
    return Claim(
        "5.2, Fig. 9b",
        "For large y0 ΔW increases with increasing exponent (y0 = 10 a0)",
        text,
        verdict(shown and not breaks, shown),
    )


def much_greater(sentence, k, depth) -> Claim:
    """ΔW beside the homogeneous value, over all amplitudes."""
    ratio = curve(k, depth, AMPLITUDES) / curve(0.0, 1.0, AMPLITUDES)
    low, high = float(ratio.min()), float(ratio.max())
    found = f"k = {k:g}, y0 = {depth:g} a0: {low:.1f} to {high:.1f} times the homogeneous value "
    found += "for Q_A between 0.05 and 0.95 μP"
    return Claim("5.2", sentence, found, verdict(low > 2))


def softer() -> Claim:
    """The direction of the grading in the sentence that follows."""
    solid = contact(0.5, THICK).solid
    ratio = float(solid.modulus(1.0) / solid.modulus(0.1))
    return Claim(
        "5.2",
        "That is, in a material that behaves more softly from the surface to the deeper regions (k > 0)",
        f"reversed: for k = 0.5 E(a0) = {ratio:.2f} E(0.1 a0), the material stiffens with depth",
        FAILS,
    )


def homogeneous_limit() -> Claim:
    """[X4] for k → 0 against the printed (59)."""
    z = 1 - AMPLITUDES
    printed = 1 - z**2 + 2 * z * np.log(z)
    away = {k: float(np.max(np.abs(curve(k, 1.0, AMPLITUDES) / printed - 1))) for k in (0.0, 1e-6, -1e-6)}
    return Claim(
        "5.2, (55)–(59)",
        "The limit k → 0 of ΔW is the closed form (59)",
        f"largest deviation {away[0.0]:.0e} at k = 0, {max(away[1e-6], away[-1e-6]):.0e} at k = ±1e-6 (y0 = a0)",
        verdict(away[0.0] < 1e-10 and max(away.values()) < 1e-4),
    )


def homogeneous_integral() -> Claim:
    """8 ∫ q h_x by quadrature of the printed (53) and (54), P from (57), c from (58)."""
    worst = 0.0
    P, E = load(NU), 1.0  # a0 = R = 1
    for share in SHARES:
        c = np.sqrt(1 - share)

        def work(x, c=c):
            q = MU * E / (2 * (1 - NU**2)) * np.sqrt(1 - x * x)
            return 8 * q * MU / 2 * (x * np.sqrt(x * x - c * c) - c * c * np.arccosh(x / c))

        energy = quad(work, c, 1, epsabs=0, epsrel=1e-11)[0]
        worst = max(worst, abs(energy / (MU**2 * P / 2) / float(curve(0.0, 1.0, share)) - 1))
    return Claim(
        "5.2, (52)–(54)",
        "(59) is the integral (52) of the homogeneous traction (53) and slip (54)",
        f"quadrature and closed form differ by {worst:.0e}",
        verdict(worst < 1e-9),
    )
