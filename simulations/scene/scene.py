"""A scene: what is asked, in the paper's symbols and SI units, checked and resolved to numbers."""

from functools import cached_property
from typing import TYPE_CHECKING, Annotated, Any, Literal

from pydantic import BaseModel, ConfigDict, Field, ValidationError, model_validator

from analytic import CylinderContact, GradedHalfPlane, ProfileContact, StretchedLoop, normal_contact

from . import solid as solids
from .errors import SceneError, shown
from .fields import LONGEST_TEXT, Text
from .indenter import Shape, named, shape_of
from .output import Output
from .resolve import fitting, typed_tables
from .settings import EffectSwitches, Mesh, Reference, Solver
from .steepness import check_steepness
from .table import KINDS
from .tables import AnyIndenter, AnyLoad, AnySolid, Fretting, Path
from .text import written

LOCKING = 0.47  # Poisson's ratio above which plain displacements lose to the mixed form, measured (docs/effects.md)


class Scene(BaseModel):
    """A checked scene: one frozen model a table. Every number is resolved to SI units; None stands for keys that do
    not apply.

    Tables may be given as models or as dictionaries; SceneError says in one line what is wrong with them.
    """

    model_config = ConfigDict(frozen=True, extra="forbid")
    title: Text = Field(default="", description="for pictures and tables")
    solid: Annotated[AnySolid, Field(discriminator="modulus")]
    indenter: Annotated[AnyIndenter, Field(discriminator="profile")]
    load: AnyLoad
    mesh: Mesh = Mesh()
    solver: Solver = Solver()
    reference: Reference = Reference()
    effects: EffectSwitches = EffectSwitches()
    output: Output = Output()

    if not TYPE_CHECKING:  # there the fields are the arguments

        def __init__(self, **given):
            title = given.pop("title", "")
            try:
                super().__init__(title=title, **typed_tables(given))
            except ValidationError as error:
                if error.errors()[0]["loc"][:1] != ("title",):  # the tables are checked: an error of the program
                    raise
                text = f"a text in one line of at most {LONGEST_TEXT} characters"
                raise SceneError(f"title = {shown(title)} is not allowed: {text}") from None

    def __getstate__(self):  # what it has worked out stays behind
        state = super().__getstate__()
        return state | {"__dict__": {name: getattr(self, name) for name in type(self).model_fields}}

    @model_validator(mode="after")
    def _tables_go_together(self):
        self._check_effects()
        a = fitting("half_width", lambda: self.half_width, self.solid, self.indenter, self.load)
        check_steepness(a, self.solid, self.indenter, self.load)
        defect = self.shape.defect(1.5 * a)
        if defect:
            raise SceneError(f"{named(self.indenter)} is not allowed: {defect}")
        return self

    def _check_effects(self):
        effects, nu = self.effects, self.solid.nu
        if self.solver.theta != 0 and not effects.coupling:
            refused = f"solver.theta = {self.solver.theta:g} is not allowed with effects.coupling = false"
            raise SceneError(f"{refused}: 0, as the pressure that limits the traction is that of theta = 0")
        if effects.symmetry is True and self.friction:
            raise SceneError("effects.symmetry = true is not allowed: the tangential load breaks it")
        if effects.friction_in_normal_stage and not effects.coupling:
            raise SceneError(
                "effects.friction_in_normal_stage = true needs effects.coupling = true: that is its subject"
            )
        if effects.incompressibility is False and nu == 0.5:
            raise SceneError("effects.incompressibility = false is not allowed at nu = 1/2: lambda is infinite")
        if effects.incompressibility is True and nu <= 0:
            raise SceneError(f"effects.incompressibility = true is not allowed at nu = {nu:g}: lambda is not positive")
        if self.is_mixed and self.mesh.degree == 1:
            raise SceneError("mesh.degree = 1 is not allowed with mixed unknowns: 2 or 3")

    @property
    def friction(self) -> bool:
        """True with a tangential problem."""
        return self.effects.friction

    @property
    def is_loop(self) -> bool:
        """True for the fretting loop, to Q_A and then cycles, at constant P."""
        return isinstance(self.load, Fretting)

    @property
    def is_path(self) -> bool:
        """True where P and Q go from point to point."""
        return isinstance(self.load, Path)

    @property
    def is_mixed(self) -> bool:
        """True where displacements and mean stress are the unknowns."""
        wanted = self.effects.incompressibility
        return self.solid.nu > LOCKING if wanted == "auto" else wanted

    @property
    def P(self) -> float:
        """Largest normal line load, N/m."""
        return self.load.P

    @property
    def mu(self) -> float:
        """Coefficient of friction; 0 without friction."""
        return (self.load.mu or 0.0) if self.friction else 0.0

    @property
    def cycles(self) -> int:
        """Cycles of the loop; 0 where there is none."""
        return self.load.cycles if isinstance(self.load, Fretting) else 0

    @property
    def material(self) -> AnySolid:
        """The solid, homogeneous where grading is switched off."""
        return solids.material(self.solid, self.effects.grading)

    @property
    def k(self) -> float:
        """Exponent of the modulus on the surface."""
        return getattr(self.material, "k", 0.0)

    @property
    def is_power_law(self) -> bool:
        """True where (1) holds at every depth, with k = 0 too."""
        return solids.is_power_law(self.material)

    @property
    def is_decoupled(self) -> bool:
        """True at the Holl ratio, where normal and tangential problem do not see each other."""
        return solids.is_decoupled(self.material)

    @property
    def contact_has_closed_form(self) -> bool:
        """True where the closed forms describe the contact: uncoupled, by nature or by choice. Effects that add to the
        virtual work are not looked at (``Effects.has_closed_form``).
        """
        return self.is_power_law and (self.is_decoupled or not (self.friction and self.effects.coupling))

    @cached_property
    def bulk_strain(self) -> float:
        """Amplitude of the uniform strain of the body along x, tension positive; 0 without."""
        load = self.load
        if not isinstance(load, Fretting):
            return 0.0
        if load.bulk_stress is None:
            return load.bulk_strain or 0.0
        depth = load.bulk_depth
        if depth is None and not solids.is_constant(self.material):
            raise SceneError("load.bulk_depth is missing: the depth at which load.bulk_stress acts, a number > 0")
        return load.bulk_stress * (1 - self.solid.nu**2) / solids.modulus_at(self.material, depth or 1.0)

    @property
    def bulk_phase(self) -> float | Literal["constant"]:
        """Lag of the bulk strain behind Q in degrees, or "constant"; 0 without."""
        return getattr(self.load, "bulk_phase", None) or 0.0

    @cached_property
    def stretched_loop(self) -> StretchedLoop | None:
        """Closed form of the uncoupled loop with bulk strain [X7], SI units; None where it does not hold."""
        load = self.load
        if not (isinstance(load, Fretting) and self.contact) or self.bulk_phase:
            return None
        try:
            return StretchedLoop(self.contact.fretting(self.mu, z=1 - load.amplitude), self.bulk_strain)
        except ValueError:
            return None

    @property
    def cell_sizes(self) -> dict[str, float]:
        """What ``mesh.Grading`` takes besides the edges."""
        return {name: v for name, v in self.mesh if name not in ("degree", "edges") and v is not None}

    @property
    def shape(self) -> Shape:
        """The indenter's profile f(x), m."""
        return shape_of(self.indenter)

    @cached_property
    def half_plane(self) -> GradedHalfPlane:
        """The half-plane of (1); for a coating, the one that it is near the surface."""
        return solids.half_plane(self.material)

    @cached_property
    def contact(self) -> CylinderContact | ProfileContact | None:
        """Closed form of the frictionless contact under P, (42)-(46) or (5)-(8); None for a coating."""
        return normal_contact(self.half_plane, self.shape.analytic(), self.P) if self.is_power_law else None

    @cached_property
    def half_width(self) -> float:
        """The contact half-width a, m; for a coating an estimate of it."""
        return self.contact.a if self.contact else solids.equivalent_half_width(self.material, self.shape, self.P)

    def a0(self, P: float) -> float:
        """The contact half-width on a homogeneous half-plane of modulus E0 under P (57), m."""
        return solids.homogeneous_half_width(self.solid.E0, self.solid.nu, self.shape, P)

    def to_keys(self) -> dict[str, Any]:
        """``{"solid.k": 0.3, …}``: every key that applies, resolved."""
        keys: dict[str, Any] = {"title": self.title}
        for table in KINDS:
            keys |= {f"{table}.{name}": value for name, value in getattr(self, table) if value is not None}
        return keys

    def to_toml(self) -> str:
        """The resolved scene as TOML, which can be run again."""
        lines, table = [], ""
        for key, value in self.to_keys().items():
            mine, _, name = key.rpartition(".")
            lines += [f"[{mine}]"] if mine != table else []
            lines.append(f"{name} = {written(value)}")
            table = mine
        return "\n".join(lines) + "\n"
