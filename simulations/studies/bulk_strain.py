"""Draw what bulk strain does to traction, stick zone and stress:  python -m simulations.studies.bulk_strain."""

import numpy as np

from analytic import CylinderContact, GradedHalfPlane, PartialSlip, StretchedLoop, StretchedPartialSlip

from ..command.command import comm, on_root, run, say
from ..output.style import panels, save, style
from .commandline import make_folders, study_parser

NU, R, P, MU, AMPLITUDE = 0.3, 0.1, 1e6, 0.3, 0.9
E0, Y0 = 210e9, 13e-3  # Pa, at a depth of 17.5 a0 [m]
EXPONENTS = (-0.3, 0.0, 0.3)
STRAIN = 2e-4
EDGE = 0.003  # distance from the trailing edge, over a, below which the largest stress is sought in equal steps
STATES = {"A": (1.0, "initial"), "C": (0.0, "unloading"), "D": (-0.5, "unloading")}


def loop(k: float, strain: float) -> StretchedLoop:
    """The loop on a solid of exponent k; ValueError where the closed form does not hold."""
    contact = CylinderContact(GradedHalfPlane(E0, NU, k, Y0), R, P)
    return StretchedLoop(contact.fretting(MU, z=1 - AMPLITUDE), strain)


def main(arguments: list[str]):
    """Three pictures of the closed form [X7]."""
    parser = study_parser("bulk_strain", __doc__, output="results/bulk_strain")
    given = on_root(lambda: make_folders(parser.parse_args(arguments)))
    if comm.rank != 0:
        return
    with style():
        paths = save(tractions(), given.output, "bulk_strain") + save(shifts(), given.output, "bulk_strain_shift")
        paths += save(stresses(), given.output, "bulk_strain_stress")
    say(f"written to {given.output}: {', '.join(path.name for path in paths)}")


def tractions():
    """q over x at three states, with strain and without, one panel an exponent."""
    note = f"closed form, uncoupled; ν = {NU:g}, Q_A = {AMPLITUDE:g} μP, μ = {MU:g}; solid: ε = {STRAIN:g}; dashed: 0"
    figure, axes = panels(len(EXPONENTS), "Traction through the cycle with bulk strain", note, 1, width=4.2, height=3.4)
    for axis, k in zip(axes.flat, EXPONENTS, strict=True):
        for colour, (state, (share, branch)) in enumerate(STATES.items()):
            for strain, line in ((STRAIN, "-"), (0.0, "--")):
                stretched = loop(k, strain)
                a, peak = stretched.loop.a, MU * stretched.loop.contact.peak_pressure
                x = a * np.sin(np.linspace(-np.pi / 2, np.pi / 2, 1201))
                q = stretched.traction(x, share * stretched.loop.Q_A, branch)
                label = f"{state}, Q = {share:g} $Q_A$" if strain else None
                axis.plot(x / a, q / peak, line, color=f"C{colour}", lw=1.2, label=label)
        axis.set(xlabel="position $x/a$ [–]", ylabel=r"traction $q/(\mu p_0)$ [–]", title=f"k = {k:g}")
    axes.flat[-1].legend(fontsize=7, loc="lower center")
    return figure


def shifts():
    """e/a over the strain, up to the end of the closed form; and that end over k."""
    solid = "E = 210 GPa at 13 mm, P = 1 MN/m, R = 0.1 m"
    note = f"closed form, uncoupled; ν = {NU:g}, Q_A = {AMPLITUDE:g} μP, μ = {MU:g}, {solid}"
    figure, axes = panels(2, "How far bulk strain moves the stick zone", note, 1, width=4.6, height=3.4)
    for k in (-0.5, *EXPONENTS, 0.6):
        strain = np.linspace(0.0, loop(k, 0.0).largest_strain, 50)
        shift = [loop(k, s).shift / loop(k, 0.0).loop.a for s in strain]
        axes.flat[0].plot(1e3 * strain, shift, label=f"k = {k:g}")
    axes.flat[0].set(xlabel="strain at $Q_A$ [10⁻³]", ylabel="shift $e/a$ [–]", title="as far as the closed form holds")
    axes.flat[0].legend(fontsize=7)
    exponents = np.linspace(-0.7, 0.8, 76)
    stretched = [loop(value, 5e-5) for value in exponents]
    axes.flat[1].plot(exponents, [one.shift / one.loop.a for one in stretched])
    axes.flat[1].set(xlabel="exponent $k$ [–]", ylabel="shift $e/a$ [–]", title="strain 5·10⁻⁵", yscale="log")
    return figure


def largest_tension(state: StretchedPartialSlip, depth: float) -> float:
    """The largest sigma_xx [Pa] at a depth [m] within half a half-width of the trailing edge."""
    a = state.contact.a
    x = -a + a * EDGE * np.sinh(np.linspace(-1.0, 1.0, 121) * np.arcsinh(0.5 / EDGE))
    return float(state.stress_xx(x, depth).max())


def stresses():
    """The largest tension at two depths over the strain, and over the depth."""
    note = f"exact for the closed form's p and q; ν = {NU:g}, Q_A = {AMPLITUDE:g} μP, μ = {MU:g}; solid: at +Q_A; "
    note += "dashed: P and the strain alone, no friction"
    figure, axes = panels(3, "Largest tensile stress within a/2 of the trailing edge", note, 1, width=4.2, height=3.4)
    depths = np.geomspace(1e-2, 1.0, 13)
    for colour, k in enumerate(EXPONENTS):
        strains = np.linspace(0.0, loop(k, 0.0).largest_strain, 7)
        for axis, depth in zip(axes.flat[:2], (0.01, 0.1)):
            axis.set(xlabel="strain at $Q_A$ [10⁻³]", title=f"at the depth {depth:g} a")
            for frictionless, line in ((False, "-"), (True, "--")):
                found = [tension(k, strain, depth, frictionless) / 1e6 for strain in strains]
                label = None if frictionless else f"k = {k:g}"
                axis.plot(1e3 * strains, found, line, color=f"C{colour}", label=label)
        for frictionless, line in ((False, "-"), (True, "--")):
            found = [tension(k, STRAIN, depth, frictionless) / 1e6 for depth in depths]
            axes.flat[2].semilogx(depths, found, line, color=f"C{colour}")
    axes.flat[2].set(xlabel="depth $y/a$ [–]", title=f"strain {1e4 * STRAIN:g}·10⁻⁴")
    for axis in axes.flat:
        axis.set(ylabel=r"largest $\sigma_{xx}$ [MPa]")
    axes.flat[0].legend(fontsize=7)
    return figure


def tension(k: float, strain: float, depth: float, frictionless: bool) -> float:
    """``largest_tension`` at +Q_A, depth over a; or of P and the strain alone."""
    state = loop(k, strain).amplitude
    depth *= state.contact.a
    if not frictionless:
        return largest_tension(state, depth)
    of_pressure = StretchedPartialSlip(PartialSlip(state.contact, MU, 0.0, 0.0), 0.0)
    return largest_tension(of_pressure, depth) + state.contact.solid.modulus(depth) * strain / (1 - NU**2)


if __name__ == "__main__":
    run(main)
