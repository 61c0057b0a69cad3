"""Answers of the maps: the grading that loses least, or most, energy under a given load."""

from math import isnan

from .points import Energies, Point, depth_factors

DEPTHS = (0.01, 0.1, 1.0, 10.0, 100.0)  # y0/a0


def ratios(
    found: dict[Point, Energies], quantity: str, m: float, amplitude: float, y0_over_a0: float
) -> dict[float, float]:
    """By k: the quantity, "energy" or "density", over that of the homogeneous contact of the same profile and load;
    empty where the latter is not among ``found``.
    """
    row = {p.k: getattr(e, quantity) for p, e in found.items() if p.m == m and p.amplitude == amplitude}
    which = ("energy", "density").index(quantity)
    if 0.0 not in row:
        return {}
    return {k: float(row[k] * depth_factors(k, m, y0_over_a0)[which] / row[0.0]) for k in sorted(row)}


def answer(
    found: dict[Point, Energies], quantity: str, m: float, amplitude: float, y0_over_a0: float
) -> dict[str, tuple[float, float]]:
    """Exponent k and ratio of the "least" and of the "most" over the exponents that ``found`` holds; nan without."""
    by_k = ratios(found, quantity, m, amplitude, y0_over_a0) or {float("nan"): float("nan")}
    least, most = min(by_k, key=lambda k: by_k[k]), max(by_k, key=lambda k: by_k[k])
    return {"least": (least, by_k[least]), "most": (most, by_k[most])}


def table(found: dict[Point, Energies], theory: dict[Point, Energies], m: float, amplitude: float) -> str:
    """Markdown: one row a depth; least (wear) and most (damping) energy and least peak density, theory in brackets."""
    text = (
        f"Profile |x|^{m:g}, Q_A = {amplitude:g} μP. "
        "Exponent k: ratio to the homogeneous contact, with coupling (theory).\n\n"
        "| y0/a0 | least energy ΔW (wear) | least peak density w | most energy ΔW (damping) |\n|---|---|---|---|\n"
    )
    for depth in DEPTHS:
        cells = []
        for quantity, end in (("energy", "least"), ("density", "least"), ("energy", "most")):
            both = [answer(source, quantity, m, amplitude, depth)[end] for source in (found, theory)]
            words = ["–" if isnan(k) else f"k = {k:g}: {ratio:.2g}" for k, ratio in both]
            cells.append(f"{words[0]} ({words[1]})")
        text += f"| {depth:g} | " + " | ".join(cells) + " |\n"
    return text.replace("= -", "= −")


def best_profile(found: dict[Point, Energies], amplitude: float, k: float, y0_over_a0: float) -> dict[float, float]:
    """By profile exponent m: energy at this grading in units that hold the load and E0 alone."""
    return {
        p.m: e.energy * float(depth_factors(k, p.m, y0_over_a0)[0])
        for p, e in found.items()
        if p.k == k and p.amplitude == amplitude
    }
