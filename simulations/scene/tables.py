"""The physics of a scene: solid, indenter and load, one frozen model for each kind."""

from itertools import pairwise
from math import inf
from typing import Annotated, ClassVar, Literal

from pydantic import Field, model_validator

from analytic import GradedHalfPlane

from .errors import SceneError, shown
from .fields import Count, Dimensionless, FormulaText, Length, LineLoad, Moduli, Number, Points, Ratio, Stress, Unit
from .fields import Word, allowed
from .table import Table, register

Exponent = Annotated[Dimensionless, Field(gt=-1, lt=1, description="exponent of E = E0 (y/y0)^k")]
PoissonRatio = Annotated[
    Dimensionless, Word("holl"), Field(gt=-1, le=0.5, description='Poisson\'s ratio; `"holl"` is 1/(2+k)')
]
Friction = Annotated[Dimensionless, Field(ge=1e-6, le=100, description="coefficient of friction")]
OnSurface = Annotated[
    Stress, Field(description="on the surface for a homogeneous solid and for linear and exponential coatings")
]
Substrate = Annotated[Stress, Field(description="modulus below a linear or exponential coating")]
AtDepth = Annotated[Stress, Field(description="modulus at depth y0")]
Y0 = Annotated[Length | None, Field(description="depth at which E is E0")]
Y0Ratio = Annotated[
    Ratio | None,
    Field(description="the same in half-widths a0 of the contact on a homogeneous half-plane of modulus E0"),
]
Thickness = Annotated[Length | None, Field(description="of a coating")]
ThicknessRatio = Annotated[Ratio | None, Field(description="the same over a0")]
Radius = Annotated[Length, Field(description="radius")]
ONE_OF_TWO = (("y0", "y0_over_a0"), ("thickness", "thickness_over_a0"))  # a length, and its ratio to a0


class Solid(Table):
    """What all solids share: "holl" for Poisson's ratio, and lengths in metres or in half-widths a0."""

    table: ClassVar[str] = "solid"
    tag: ClassVar[str] = "modulus"

    @model_validator(mode="after")
    def _one_of_two(self):
        for pair in ONE_OF_TWO:
            if pair[0] in type(self).model_fields:
                given = [name for name in pair if getattr(self, name) is not None]
                if not given:
                    or_that = " or ".join(f"solid.{n}: {allowed(type(self).model_fields[n])}" for n in pair)
                    raise SceneError(f"solid.{pair[0]} is missing: {or_that.partition(': ')[2]}")
                if len(given) > 1:
                    both = " and ".join(f"solid.{name} = {getattr(self, name):g}" for name in given)
                    raise SceneError(f"{both} are not allowed together: one of them is to be given")
        return self

    @model_validator(mode="wrap")
    @classmethod
    def _holl_ratio(cls, given, check):
        nu = given.get("nu") if isinstance(given, dict) else None
        if not (isinstance(nu, str) and nu == "holl"):
            return check(given)
        k = getattr(check(given | {"nu": 0.0}), "k", 0.0)
        if k < 0 or cls not in (PowerLaw, Homogeneous):
            modulus = "" if cls is PowerLaw else f'modulus = "{cls.model_fields["modulus"].default}", '
            reason = f"needs a power law with k ≥ 0, here {modulus}k = {k:g}"
            raise SceneError(f'solid.nu = "holl" is not allowed: {reason}')
        return check(given | {"nu": GradedHalfPlane.holl_ratio(k)})


class PowerLaw(Solid):
    """E = E0 (y/y0)^k at every depth y."""

    modulus: Literal["power law"] = Field(default="power law", description="how E varies with depth y")
    E0: AtDepth
    k: Exponent
    nu: PoissonRatio
    y0: Y0 = None
    y0_over_a0: Y0Ratio = None


class Homogeneous(Solid):
    """E = E0 everywhere."""

    modulus: Literal["homogeneous"] = "homogeneous"
    E0: OnSurface
    nu: PoissonRatio


class PowerLawCoating(Solid):
    """E = E0 (y/y0)^k down to the thickness, constant below."""

    modulus: Literal["power-law coating"] = "power-law coating"
    E0: AtDepth
    k: Exponent
    nu: PoissonRatio
    y0: Y0 = None
    y0_over_a0: Y0Ratio = None
    thickness: Thickness = None
    thickness_over_a0: ThicknessRatio = None


class LinearCoating(Solid):
    """E linear from E0 on the surface to E_substrate at the thickness, constant below."""

    modulus: Literal["linear"] = "linear"
    E0: OnSurface
    E_substrate: Substrate
    nu: PoissonRatio
    thickness: Thickness = None
    thickness_over_a0: ThicknessRatio = None


class ExponentialCoating(Solid):
    """E exponential from E0 on the surface to E_substrate at the thickness, constant below."""

    modulus: Literal["exponential"] = "exponential"
    E0: OnSurface
    E_substrate: Substrate
    nu: PoissonRatio
    thickness: Thickness = None
    thickness_over_a0: ThicknessRatio = None


class Tabulated(Solid):
    """E linear between points, constant below the last."""

    modulus: Literal["tabulated"] = "tabulated"
    points: Moduli = Field(description="depth and modulus, linear in between, constant below the last; from depth 0 on")
    nu: PoissonRatio

    @property
    def E0(self) -> float:
        """E on the surface, Pa."""
        return self.points[0][1]

    @property
    def E_substrate(self) -> float:
        """E below the last point, Pa."""
        return self.points[-1][1]

    @property
    def thickness(self) -> float:
        """Depth of the last point, m."""
        return self.points[-1][0]

    @model_validator(mode="after")
    def _downwards(self):
        depths = [y for y, _ in self.points]
        if depths[0] != 0 or any(below <= above for above, below in pairwise(depths)):
            given = shown([list(point) for point in self.points])
            raise SceneError(f"solid.points = {given} is not allowed: depths grow from 0 on")
        return self


class Indenter(Table):
    """What all indenters share."""

    table: ClassVar[str] = "indenter"
    tag: ClassVar[str] = "profile"


class Parabola(Indenter):
    """f = x²/(2 R)."""

    profile: Literal["parabola"] = Field(default="parabola", description="shape f(x) of the rigid indenter")
    R: Radius


class Circle(Indenter):
    """f = R - sqrt(R² - x²)."""

    profile: Literal["circle"] = "circle"
    R: Radius


class Power(Indenter):
    """f = R (|x|/R)^m / m."""

    profile: Literal["power"] = "power"
    R: Length = Field(description="length of a power law")
    exponent: Dimensionless = Field(gt=1, le=20, description="m in f = R (|x|/R)^m / m")


class RoundedFlat(Indenter):
    """f = 0 for |x| < flat, (|x| - flat)²/(2 R) beyond."""

    profile: Literal["rounded flat"] = "rounded flat"
    R: Radius
    flat: Length = Field(description="half-width of the flat of a rounded flat punch")


class Formula(Indenter):
    """f as arithmetic of x and R."""

    profile: Literal["formula"] = "formula"
    formula: FormulaText = Field(description="f(x) for x ≥ 0, with x and R in m, convex and 0 at 0")
    R: Length | None = Field(default=None, description="R in a formula")


class Load(Table):
    """What all load schedules share."""

    table: ClassVar[str] = "load"


class Fretting(Load):
    """P, then Q to +Q_A, then cycles to -Q_A and back."""

    beside: ClassVar[str] = "load.P"
    P: LineLoad = Field(description="normal line load")
    mu: Friction
    amplitude: Dimensionless = Field(ge=1e-6, lt=1, description="Q_A/(μ P)")
    cycles: Count = Field(default=1, ge=0, le=1000, description="to −Q_A and back; 0 stops at +Q_A")
    bulk_strain: Annotated[Dimensionless, Field(ge=-0.1, le=0.1)] | None = Field(
        default=None,
        description="amplitude of a uniform strain of the body along x, tension > 0: [bulk_strain.md](bulk_strain.md)",
    )
    bulk_stress: Annotated[Number, Unit("Pa"), Field(ge=-1e12, le=1e12)] | None = Field(
        default=None, description="the same as the stress E ε/(1−ν²) at the depth `bulk_depth`"
    )
    bulk_depth: Length | None = Field(
        default=None, description="depth at which `bulk_stress` acts; not needed where E is constant"
    )
    bulk_phase: Annotated[Number, Unit("°"), Field(ge=-180, le=180)] | Literal["constant"] | None = Field(
        default=None,
        description='lag of the strain behind Q, 0 if empty; "constant": it grows with Q up to +Q_A, and stays',
    )

    @property
    def strain_lags(self) -> bool:
        """Whether Q and the bulk strain go round an ellipse."""
        return self.bulk_phase not in (None, 0, "constant")

    @model_validator(mode="after")
    def _bulk_keys_go_together(self):
        if self.bulk_strain is not None and self.bulk_stress is not None:
            both = f"load.bulk_strain = {self.bulk_strain:g} and load.bulk_stress = {self.bulk_stress:g}"
            raise SceneError(f"{both} are not allowed together: one of them is to be given")
        if self.bulk_depth is not None and self.bulk_stress is None:
            raise SceneError(f"load.bulk_depth = {self.bulk_depth:g} is not allowed without load.bulk_stress")
        phase = f"load.bulk_phase = {shown(self.bulk_phase)} is not allowed without"
        if self.bulk_phase is not None and self.bulk_strain is None and self.bulk_stress is None:
            raise SceneError(f"{phase} load.bulk_strain or load.bulk_stress")
        if self.bulk_phase is not None and self.cycles == 0:
            raise SceneError(f"{phase} a cycle, here load.cycles = 0")
        return self


class Indentation(Load):
    """P alone."""

    beside: ClassVar[str] = "effects.friction = false"
    P: LineLoad = Field(description="normal line load")


class Path(Load):
    """Straight from point to point of (P, Q)."""

    beside: ClassVar[str] = "load.points"
    points: Points = Field(
        description="path of (P, Q), instead of P, amplitude and cycles; |Q| < μ P, the first Q is 0; without "
        "friction up to the first Q that is not 0, unless `effects.friction_in_normal_stage`"
    )
    mu: Friction | None = None

    @property
    def P(self) -> float:
        """Largest normal line load, N/m."""
        return max(P for P, _ in self.points)

    @model_validator(mode="after")
    def _without_sliding(self):
        refused = f"load.points = {shown([list(point) for point in self.points])} is not allowed"
        if self.mu is None and any(Q for _, Q in self.points):
            raise SceneError(f"load.mu is missing: load.points has Q; {allowed(Fretting.model_fields['mu'])}")
        if self.points[0][1] != 0:
            raise SceneError(f"{refused}: the first point has Q = 0")
        for P, Q in self.points:
            if abs(Q) >= (self.mu or inf) * P:
                raise SceneError(f"{refused}: |Q| < mu P, here P = {P:g}, Q = {Q:g}")
        return self


AnySolid = PowerLaw | Homogeneous | PowerLawCoating | LinearCoating | ExponentialCoating | Tabulated
AnyIndenter = Parabola | Circle | Power | RoundedFlat | Formula
AnyLoad = Fretting | Indentation | Path
BULK = ("bulk_strain", "bulk_stress", "bulk_depth", "bulk_phase")
TANGENTIAL = ("mu", "amplitude", "cycles", *BULK)  # keys of a load with friction
register(PowerLaw, Homogeneous, PowerLawCoating, LinearCoating, ExponentialCoating, Tabulated)
register(Parabola, Circle, Power, RoundedFlat, Formula)
register(Fretting, Indentation, Path)
