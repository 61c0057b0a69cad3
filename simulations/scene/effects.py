"""Which physical effects a scene calls for, and why. One entry an effect; everything else asks here.

To add an effect, write its integrand in ``forms/`` and an entry in ALL: the keys it adds to the scene language, when it
is on, and the term that it adds to the virtual work.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from typing import TYPE_CHECKING

from .language import Key, SceneError

if TYPE_CHECKING:
    from .scene import Scene

LOCKING = 0.47  # Poisson's ratio above which plain displacements lose to the mixed form, measured (docs/effects.md)


@dataclass(frozen=True)
class Verdict:
    """Whether an effect is on, why, and what it adds to the problem or what is left out without it."""

    on: bool
    why: str
    consequence: str


@dataclass(frozen=True)
class Effect:
    """One effect: its verdict on a scene, its keys in the scene language, and its term in the forms.

    work: function of scene and scales that returns the term of the virtual work, itself a function
    ``(body, v) -> form`` linear in ``body.u``; None where the effect is built into the contact problem.
    """

    name: str
    judge: Callable[[Scene], Verdict]
    keys: Mapping[str, Key] = field(default_factory=dict)
    work: Callable | None = None


class Effects:
    """The effects of a scene, by name:  ``"friction" in effects``; ``verdicts`` has all of them."""

    def __init__(self, scene: Scene):
        self.verdicts = {effect.name: effect.judge(scene) for effect in ALL}

    def __contains__(self, name: str) -> bool:
        return self.verdicts[name].on

    def works(self, scene: Scene, scales) -> list[Callable]:
        """Terms that effects add to the virtual work of the body."""
        return [effect.work(scene, scales) for effect in ALL if effect.work and effect.name in self]

    def __str__(self):
        return "\n".join(
            f"{name:26s} {'on ' if verdict.on else 'off'}  {verdict.why}: {verdict.consequence}"
            for name, verdict in self.verdicts.items()
        )


def keys() -> dict[str, Key]:
    """Keys of all effects."""
    return {name: key for effect in ALL for name, key in effect.keys.items()}


def grading(scene: Scene) -> Verdict:
    """E varies with depth unless it is homogeneous."""
    if not scene["effects.grading"]:
        return Verdict(False, "effects.grading = false", f"E = E0 = {scene['solid.E0']:g} everywhere")
    kind, k = scene["solid.modulus"], scene.k
    if kind in ("exponential", "linear"):
        return Verdict(True, f"{kind} coating", "E varies down to its thickness, layers in y")
    if k == 0:
        return Verdict(False, "k = 0" if kind != "homogeneous" else kind, "constant modulus, mesh in depth y")
    layers = "layers in s = y^(1-k), where u is smooth" if k > 0 else "modulus infinite on the surface, layers in y"
    return Verdict(True, f"{kind}, k = {k:g}", layers)


def friction(scene: Scene) -> Verdict:
    """A tangential load calls for friction."""
    if not scene.friction:
        return Verdict(False, "no tangential load", "no tangential unknown, term or result")
    load = f"Q_A = {scene['load.amplitude']:g} mu P" if scene.is_loop else "load.points"
    terms = "tangential contact terms, delta_x, memory of slip"
    return Verdict(True, f"mu = {scene['load.mu']:g}, {load}", terms)


def symmetry(scene: Scene) -> Verdict:
    """Without a tangential load the halves are mirror images."""
    wanted = scene["effects.symmetry"]
    if scene.friction:
        if wanted is True:
            raise SceneError("effects.symmetry = true is not allowed: the tangential load breaks it")
        return Verdict(False, "the tangential load breaks it", "both halves are meshed")
    if wanted is False:
        return Verdict(False, "effects.symmetry = false", "both halves are meshed")
    return Verdict(True, "only the normal load", "the half x > 0 is meshed")


def coupling(scene: Scene) -> Verdict:
    """Pressure moves the surface sideways and traction moves it up and down, except at the Holl ratio."""
    if not scene.friction:
        return Verdict(False, "no tangential load", "nothing to couple")
    if not scene["effects.coupling"]:
        held = "the frictionless pressure limits the traction and does not feel it, as in the closed forms"
        return Verdict(False, "effects.coupling = false", held)
    why = "effects.coupling = true" + (", though at the Holl ratio it vanishes" if scene.is_decoupled else "")
    return Verdict(True, why, "pressure and traction in one system")


def friction_in_normal_stage(scene: Scene) -> Verdict:
    """Friction from first contact on, or only once the tangential load starts."""
    if not (scene.friction and scene["effects.friction_in_normal_stage"]):
        return Verdict(False, "the paper's case", "pressed on without friction")
    if not scene["effects.coupling"]:
        raise SceneError("effects.friction_in_normal_stage = true needs effects.coupling = true: that is its subject")
    steps = f"P in {scene['solver.normal_increments']} increments"
    return Verdict(True, "effects.friction_in_normal_stage = true", steps)


def incompressibility(scene: Scene) -> Verdict:
    """Near nu = 1/2 plain displacements lock."""
    wanted, nu = scene["effects.incompressibility"], scene["solid.nu"]
    if wanted is False and nu == 0.5:
        raise SceneError("effects.incompressibility = false is not allowed at nu = 1/2: lambda is infinite")
    if wanted is True and nu <= 0:
        raise SceneError(f"effects.incompressibility = true is not allowed at nu = {nu:g}: lambda is not positive")
    on = nu > LOCKING if wanted == "auto" else wanted
    why = f"nu = {nu:.4g}" if wanted == "auto" else f"effects.incompressibility = {str(wanted).lower()}"
    return Verdict(on, why, "displacements and mean stress" if on else "displacements alone")


def load_programme(scene: Scene) -> Verdict:
    """One loading, cycles, or a path."""
    if not scene.is_loop:
        points = len(scene.values.get("load.points", [None]))
        return Verdict(points > 1, f"{points} load(s)", "straight from point to point" if points > 1 else "P alone")
    cycles = scene["load.cycles"]
    if cycles == 0:
        return Verdict(False, "load.cycles = 0", "monotone, stops at +Q_A")
    return Verdict(True, f"load.cycles = {cycles}", "to +Q_A, then to -Q_A and back")


def profile(scene: Scene) -> Verdict:
    """The indenter's shape, the parabola unless another is asked for."""
    shape = scene["indenter.profile"]
    formula = scene.values.get("indenter.formula", "")
    return Verdict(shape != "parabola", f"{shape} {formula}".strip(), "nodal values of f(x), its own closed form")


TRUTH = Key(kind=bool, default=True)
ALL = (
    Effect("grading", grading, {"effects.grading": TRUTH}),
    Effect("friction", friction, {"effects.friction": TRUTH}),
    Effect("symmetry", symmetry, {"effects.symmetry": Key(kind=bool, default="auto", word="auto")}),
    Effect("coupling", coupling, {"effects.coupling": TRUTH}),
    Effect(
        "friction in normal stage",
        friction_in_normal_stage,
        {"effects.friction_in_normal_stage": Key(kind=bool, default=False)},
    ),
    Effect(
        "incompressibility",
        incompressibility,
        {"effects.incompressibility": Key(kind=bool, default="auto", word="auto")},
    ),
    Effect("load programme", load_programme),
    Effect("indenter profile", profile),
)
