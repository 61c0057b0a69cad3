"""Which physical effects a scene calls for, and why. One entry an effect; everything else asks here."""

from dataclasses import dataclass

from .scene import Scene


@dataclass(frozen=True)
class Effect:
    """One effect: whether it is on, why, and what it adds to the problem or what is left out without it."""

    name: str
    on: bool
    why: str
    consequence: str

    def __str__(self):
        return f"{self.name:26s} {'on ' if self.on else 'off'}  {self.why}: {self.consequence}"


class Effects:
    """The effects of a scene, by name:  ``effects.friction``, ``effects.coupling`` ..."""

    def __init__(self, scene: Scene):
        self.listed = [effect(scene) for effect in ALL]
        self._on = {effect.name: effect.on for effect in self.listed}

    @property
    def grading(self) -> bool:
        """The modulus varies with depth."""
        return self._on["grading"]

    @property
    def friction(self) -> bool:
        """There is a tangential problem."""
        return self._on["friction"]

    @property
    def coupling(self) -> bool:
        """Normal and tangential tractions see each other's displacements."""
        return self._on["coupling"]

    @property
    def friction_in_normal_stage(self) -> bool:
        """Points may stick while the cylinder is pressed on."""
        return self._on["friction in normal stage"]

    @property
    def symmetry(self) -> bool:
        """Half of the problem tells the whole."""
        return self._on["symmetry"]


def grading(scene: Scene) -> Effect:
    """E varies with depth where k is not 0."""
    k = scene["solid.k"]
    if k == 0:
        return Effect("grading", False, "k = 0", "constant modulus, mesh in depth y")
    layers = "layers in s = y^(1-k), where u is smooth" if k > 0 else "modulus infinite on the surface, layers in y"
    return Effect("grading", True, f"k = {k:g}", layers)


def friction(scene: Scene) -> Effect:
    """A tangential load calls for friction."""
    if not scene["effects.friction"]:
        left_out = "no tangential unknown, term or result"
        return Effect("friction", False, "no tangential load", left_out)
    amplitude = f"mu = {scene['load.mu']:g}, Q_A = {scene['load.amplitude']:g} mu P"
    return Effect("friction", True, amplitude, "tangential contact terms, delta_x, memory of slip")


def symmetry(scene: Scene) -> Effect:
    """Without a tangential load the halves are mirror images."""
    if scene["effects.friction"]:
        return Effect("symmetry", False, "the tangential load breaks it", "both halves are meshed")
    return Effect("symmetry", True, "only the normal load", "the half x > 0 is meshed")


def coupling(scene: Scene) -> Effect:
    """Pressure moves the surface sideways and traction moves it up and down, except at the Holl ratio."""
    if not scene["effects.friction"]:
        return Effect("coupling", False, "no tangential load", "nothing to couple")
    if not scene["effects.coupling"]:
        held = "the pressure of the normal stage stays and limits the traction, as in the closed forms"
        return Effect("coupling", False, "effects.coupling = false", held)
    why = "effects.coupling = true" + (", though at the Holl ratio it vanishes" if scene.is_decoupled else "")
    return Effect("coupling", True, why, "pressure and traction in one system")


def friction_in_normal_stage(scene: Scene) -> Effect:
    """Friction from first contact on, or only once the tangential load starts."""
    if not (scene["effects.friction"] and scene["effects.friction_in_normal_stage"]):
        return Effect("friction in normal stage", False, "the paper's case", "pressed on without friction")
    steps = f"P in {scene['solver.normal_increments']} increments"
    return Effect("friction in normal stage", True, "effects.friction_in_normal_stage = true", steps)


ALL = (grading, friction, symmetry, coupling, friction_in_normal_stage)
