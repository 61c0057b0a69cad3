"""The table [output]: states, fields, lines and points of the body that a run writes."""

from typing import Annotated, ClassVar, Literal

from pydantic import BeforeValidator, Field

from .fields import Lines, ListOf, Places, StateNames, among
from .table import Table, register

STRESSES = ("stress_xx", "stress_yy", "stress_xy", "stress_zz")
FIELDS = (  # every field of the body by name, in the order of the files
    "displacement",
    *STRESSES,
    "principal_1",
    "principal_2",
    "principal_3",
    "max_shear",
    "von_mises",
    "energy_density",
)
FieldNames = Annotated[
    tuple[str, ...], BeforeValidator(among(FIELDS)), ListOf(f"a list of {', '.join(FIELDS)}", {"enum": list(FIELDS)})
]
NORMAL = "normal"  # the name of the state at the end of the normal stage


class Output(Table):
    """Fields in the body, of which files are written."""

    table: ClassVar[str] = "output"
    states: Literal["named", "all"] | StateNames = Field(
        default="named",
        description='states whose fields are kept: the end of the normal stage and A to E (or the points of a path); '
        'every load step; or names, as in `["normal", "A", "C"]`',
    )
    fields: Literal["all"] | FieldNames = Field(
        default="all", description="fields that are kept, see [files.md](files.md)"
    )
    lines: Lines = Field(
        default=(),
        description="straight lines through the body, n points each, whose fields go to `lines.csv`; x along the "
        "surface, y the depth",
    )
    points: Places = Field(default=(), description="points in the body, likewise")

    @property
    def kept(self) -> tuple[str, ...]:
        """The fields that are kept, in the order of FIELDS."""
        return tuple(name for name in FIELDS if self.fields == "all" or name in self.fields)


register(Output)
