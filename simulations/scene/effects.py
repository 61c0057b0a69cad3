"""Which physical effects a scene calls for, and why. One entry an effect; everything else asks here.

To add an effect, write its integrand in ``forms/`` and an entry in ALL: the keys it adds to the scene language, when it
is on, and the term that it adds to the virtual work.
"""

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from typing import Any

from .errors import SceneError
from .scene import Scene
from .settings import add_switches
from .table import KINDS


@dataclass(frozen=True)
class Verdict:
    """Whether an effect is on, why, and what it adds to the problem or what is left out without it."""

    on: bool
    why: str
    consequence: str


@dataclass(frozen=True)
class Effect:
    """One effect: its verdict on a scene, its keys in the table [effects], and its term in the forms.

    keys: by name, each as ``(type, Field(default, description=...))``: ``scene.effects.NAME`` is then its value.
    Those of the effects below are fields of ``EffectSwitches``.
    work: function of scene and scales that returns the term of the virtual work, itself a function
    ``(body, v) -> form`` linear in ``body.u``; None where the effect is built into the contact problem.
    keeps_reference: True where closed forms or the half-plane solver describe the physics with this effect too;
    mesh_free_only: where of these only the mesh-free solver does.
    """

    name: str
    judge: Callable[[Scene], Verdict]
    keys: Mapping[str, tuple[Any, Any]] = field(default_factory=dict)
    work: Callable | None = None
    keeps_reference: bool = False
    mesh_free_only: bool = False


class Effects:
    """The effects of a scene, by name:  ``"friction" in effects``; ``verdicts`` has all of them.

    ``without_reference``: names of those that are on and that no reference describes; ``without_closed_form``: these,
    and those that only the mesh-free solver describes; ``has_closed_form``: True where the closed forms describe the
    same problem.
    """

    def __init__(self, scene: Scene):
        others = sorted({*dict(scene.effects)} ^ {*KINDS["effects"][0].model_fields})
        if others:
            raise SceneError(
                f"effects.{others[0]}: its effect was added or removed after the scene was made; "
                "make_scene(base=scene) makes it again"
            )
        self.verdicts = {effect.name: effect.judge(scene) for effect in ALL}
        on = [effect for effect in ALL if effect.name in self]
        self.without_reference = [effect.name for effect in on if not effect.keeps_reference]
        self.without_closed_form = [e.name for e in on if e.mesh_free_only or not e.keeps_reference]
        self.has_closed_form = scene.contact_has_closed_form and not self.without_closed_form
        if "bulk strain" in self and scene.stretched_loop is None:
            self.has_closed_form = False

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


def grading(scene: Scene) -> Verdict:
    """E varies with depth unless it is homogeneous."""
    if not scene.effects.grading:
        return Verdict(False, "effects.grading = false", f"E = E0 = {scene.solid.E0:g} Pa everywhere")
    kind, k = scene.solid.modulus, scene.k
    if kind in ("exponential", "linear", "tabulated"):
        return Verdict(True, f"{kind} coating", "E varies down to its thickness, layers in y")
    if k == 0:
        return Verdict(False, "k = 0" if kind != "homogeneous" else kind, "constant modulus, mesh in depth y")
    layers = "layers in s = y^(1-k), where u is smooth" if k > 0 else "modulus infinite on the surface, layers in y"
    return Verdict(True, f"{kind}, k = {k:g}", layers)


def friction(scene: Scene) -> Verdict:
    """A tangential load calls for friction."""
    if not scene.friction:
        return Verdict(False, "no tangential load", "no tangential unknown, term or result")
    load = f"Q_A = {scene.load.amplitude} mu P" if scene.is_loop else "load.points"
    terms = "tangential contact terms, delta_x, anchors of stick"
    return Verdict(True, f"mu = {scene.load.mu:g}, {load}", terms)


def symmetry(scene: Scene) -> Verdict:
    """Without a tangential load the halves are mirror images."""
    if scene.friction:
        return Verdict(False, "the tangential load breaks it", "both halves are meshed")
    if scene.effects.symmetry is False:
        return Verdict(False, "effects.symmetry = false", "both halves are meshed")
    return Verdict(True, "only the normal load", "the half x > 0 is meshed")


def coupling(scene: Scene) -> Verdict:
    """Pressure moves the surface sideways and traction moves it up and down, except at the Holl ratio."""
    if not scene.friction:
        return Verdict(False, "no tangential load", "nothing to couple")
    held = "the frictionless pressure limits the traction and does not feel it, as in the closed forms"
    if not scene.effects.coupling:
        return Verdict(False, "effects.coupling = false", held)
    in_one_system = scene.solver.theta != 0 or scene.effects.friction_in_normal_stage
    if scene.is_decoupled and scene.is_path and not in_one_system:
        # the mesh has a little coupling of its own: a steep p moves surface nodes beside an edge of contact, and points
        # that this edge passes would keep that for good
        return Verdict(False, "a path of loads at the Holl ratio, where it vanishes", held)
    why = "effects.coupling = true" + (", though at the Holl ratio it vanishes" if scene.is_decoupled else "")
    return Verdict(True, why, "pressure and traction in one system")


def elastic_slip(scene: Scene) -> Verdict:
    """Stuck points slip elastically where a length is given: Coulomb's law is regularised."""
    length = scene.effects.elastic_slip
    if not scene.friction or length is None:
        return Verdict(False, "no length given" if scene.friction else "no tangential load", "Coulomb's law as it is")
    return Verdict(True, f"effects.elastic_slip = {length:g}", "regularised: stuck points slip in proportion to q")


def friction_in_normal_stage(scene: Scene) -> Verdict:
    """Friction from first contact on, or only once the tangential load starts."""
    if not (scene.friction and scene.effects.friction_in_normal_stage):
        return Verdict(False, "the paper's case", "pressed on without friction")
    steps = f"P in {scene.solver.normal_increments} increments"
    return Verdict(True, "effects.friction_in_normal_stage = true", steps)


def incompressibility(scene: Scene) -> Verdict:
    """Near nu = 1/2 plain displacements lock."""
    wanted, on = scene.effects.incompressibility, scene.is_mixed
    why = f"nu = {scene.solid.nu:.4g}" if wanted == "auto" else f"effects.incompressibility = {str(wanted).lower()}"
    return Verdict(on, why, "displacements and mean stress" if on else "displacements alone")


def load_schedule(scene: Scene) -> Verdict:
    """One loading, cycles, or a path."""
    if not scene.is_loop:
        points = len(scene.load.points) if scene.is_path else 1
        return Verdict(points > 1, f"{points} load(s)", "straight from point to point" if points > 1 else "P alone")
    cycles = scene.load.cycles
    if cycles == 0:
        return Verdict(False, "load.cycles = 0", "monotone, stops at +Q_A")
    return Verdict(True, f"load.cycles = {cycles}", "to +Q_A, then to -Q_A and back")


def bulk_strain(scene: Scene) -> Verdict:
    """A uniform strain of the body moves the surface past the indenter; nothing else feels it."""
    strain = scene.bulk_strain
    if not strain:
        return Verdict(False, "no load.bulk_strain", "the body far from the contact is at rest")
    phase = scene.bulk_phase
    course = "constant from +Q_A on" if phase == "constant" else f"{phase:g} degrees behind Q" if phase else "in phase"
    return Verdict(True, f"amplitude {strain:.4g}, {course}", "slip gains eps x, displacement and stress the far field")


def profile(scene: Scene) -> Verdict:
    """The indenter's shape, the parabola unless another is asked for."""
    shape = scene.indenter.profile
    formula = getattr(scene.indenter, "formula", "")
    if shape == "parabola":
        return Verdict(False, shape, "no other profile")
    exponent = getattr(scene.indenter, "exponent", None)
    power = f"exponent {exponent:g}" if exponent is not None else ""
    return Verdict(True, " ".join(filter(None, (shape, formula, power))), "nodal values of f(x)")


ALL: list[Effect] = []


def add(*effects: Effect):
    """Let every scene have these effects: keys, verdicts and terms. One takes the place of another of its name."""
    names, before = [effect.name for effect in effects], [*ALL]
    ALL[:] = [*(effect for effect in ALL if effect.name not in names), *effects]
    try:
        _update_keys()
    except Exception:  # keys that are none: other scenes must not meet them
        ALL[:] = before
        raise


def remove(*effects: Effect):
    """Undo ``add``."""
    left = [*ALL]
    for effect in effects:  # all of them, or an error and none
        left.remove(effect)
    ALL[:] = left
    _update_keys()


def _update_keys():
    add_switches({name: key for effect in ALL for name, key in effect.keys.items()})


add(
    Effect("grading", grading, keeps_reference=True),
    Effect("friction", friction, keeps_reference=True),
    Effect("symmetry", symmetry, keeps_reference=True),
    Effect("coupling", coupling, keeps_reference=True),
    Effect("elastic slip (regularised)", elastic_slip, keeps_reference=True, mesh_free_only=True),
    Effect("friction in normal stage", friction_in_normal_stage, keeps_reference=True),
    Effect("incompressibility", incompressibility, keeps_reference=True),
    Effect("load schedule", load_schedule, keeps_reference=True),
    Effect("bulk strain", bulk_strain, keeps_reference=True),
    Effect("indenter profile", profile, keeps_reference=True),
)
