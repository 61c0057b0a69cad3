"""Settings of the solution: mesh, solver, reference, and switches of effects, one frozen model each."""

from collections.abc import Mapping
from typing import Annotated, Any, ClassVar, Literal

from pydantic import Field, create_model, model_validator

from .accuracy import LARGEST
from .errors import SceneError
from .fields import Count, Dimensionless, Length, Number, Truth, Unit, is_number, plain
from .table import KINDS, Table, register

HalfWidths = Annotated[Number, Unit("a")]


class Mesh(Table):
    """Cell sizes in contact half-widths a."""

    table: ClassVar[str] = "mesh"
    facet: HalfWidths = Field(default=0.025, ge=1e-3, le=0.5, description="largest facet under the indenter")
    edge_facet: HalfWidths = Field(
        default=1e-3, ge=1e-6, le=0.5, description="smallest facet, at the edges of contact and stick"
    )
    growth: Dimensionless = Field(default=1.3, ge=1.02, le=3, description="ratio of neighbouring column widths")
    first_layer: HalfWidths = Field(default=1e-3, ge=1e-7, le=0.5, description="height of surface cells (k > 0: less)")
    layer_growth: Dimensionless = Field(default=1.3, ge=1.02, le=3, description="ratio of neighbouring layer heights")
    edge_at: Annotated[Dimensionless, Field(ge=0, le=1)] | None = Field(
        default=None,
        description="where in its facet an edge of contact or stick lies, from 0 at the inner end; "
        "empty: where it costs least, if the edges are known exactly, else wherever it falls",
    )
    extent: HalfWidths = Field(
        default=20.0,
        ge=4,
        le=1e4,
        description="half-width and depth of the domain; multiplied by 5 for a coated body, for bulk strain, and with "
        "coupling unless ν is the Holl ratio (coupling with k < 0: by 5^(1/(1+k)), at most by 10). If a coating is "
        "thicker than a, the unit is its thickness",
    )
    degree: Count = Field(default=2, ge=1, le=3, description="polynomial degree of the displacements")
    edges: Literal["turns", "states"] = Field(
        default="turns", description="edges to which the mesh is graded: where the load turns, or at all states A to E"
    )


class Solver(Table):
    """Newton's method, load increments and Nitsche's parameters."""

    table: ClassVar[str] = "solver"
    method: Literal["condensed", "full"] = Field(
        default="condensed", description="contact forces alone as unknowns, or every displacement"
    )
    normal_increments: Count = Field(
        default=20,
        ge=1,
        le=1000,
        description="load steps of P with friction in the normal stage; equal in the half-width under a power profile",
    )
    increments: Count = Field(
        default=6,
        ge=1,
        le=1000,
        description="load steps per quarter cycle, or between points; 12 where a bulk strain lags behind Q",
    )
    gamma0: Dimensionless = Field(
        default=10.0, ge=1e-3, le=1e6, description="Nitsche's parameter over m² E/((1−ν²) h), m = mesh.degree"
    )
    accuracy: Annotated[Dimensionless, Field(gt=0, lt=LARGEST)] | None = Field(
        default=None, description="largest relative error wanted; chooses the mesh, see [cost.md](cost.md)"
    )
    theta: Dimensionless = Field(
        default=0.0,
        ge=-1,
        le=1,
        description='Nitsche\'s variant; other than 0 it needs `method = "full"`, which is then the default',
    )

    @model_validator(mode="before")
    @classmethod
    def _full_for_theta(cls, given):
        theta = plain(given.get("theta", 0))
        return {"method": "full"} | given if is_number(theta) and theta != 0 else given

    @model_validator(mode="after")
    def _theta_needs_full(self):
        if self.theta != 0 and self.method != "full":
            refused = f'solver.theta = {self.theta:g} is not allowed with solver.method = "{self.method}"'
            raise SceneError(f'{refused}: 0, or solver.method = "full"')
        return self


class Reference(Table):
    """What a run is compared with."""

    table: ClassVar[str] = "reference"
    kind: Literal["auto", "closed form", "half-plane", "none"] = Field(
        default="auto", description='what the run is compared with; "auto": a solution of the same physics'
    )


class EffectSwitches(Table):
    """Effects that are switched on or off, or chosen by the scene ("auto")."""

    table: ClassVar[str] = "effects"
    grading: Truth = Field(default=True, description="false: E = E0 everywhere")
    friction: Truth = Field(default=True, description="on where [load] has a key of friction; false forbids these keys")
    symmetry: Truth | Literal["auto"] = Field(
        default="auto", description="half the domain; auto: without tangential load"
    )
    coupling: Truth = Field(
        default=True,
        description="pressure and traction in one system; false: as in the closed forms. So is a path of loads at the "
        "Holl ratio, unless `solver.theta` or friction in the normal stage needs one system",
    )
    elastic_slip: Length | None = Field(
        default=None,
        description="regularises Coulomb's law: a stuck point slips in proportion to its traction, by this length at "
        "q = μP/(2a), for a coating with the a that scales lengths, not the contact's own; empty: not at all",
    )
    friction_in_normal_stage: Truth = Field(default=False, description="friction from the first contact on")
    incompressibility: Truth | Literal["auto"] = Field(
        default="auto", description="mean stress as a field of its own; auto: where ν > 0.47"
    )

    def __reduce__(self):  # a model with added keys has no name that a pickle could find
        return switches, (dict(self),)


def switches(values: Mapping[str, Any]) -> EffectSwitches:
    """The table [effects] with the keys that effects have added to it."""
    model = KINDS["effects"][0]
    assert issubclass(model, EffectSwitches)
    return model(**values)


def add_switches(keys: Mapping[str, Any]):
    """Give the table [effects] these keys beside its own, each as ``(type, Field(default, …))``."""
    register(create_model("EffectSwitches", __base__=EffectSwitches, **keys) if keys else EffectSwitches)


register(Mesh)
register(Solver)
register(Reference)
register(EffectSwitches)
