"""Base of every table of a scene: a frozen model whose refusals are one line with key, value and what is allowed."""

import difflib
from collections.abc import Mapping
from typing import TYPE_CHECKING, Any, ClassVar

from pydantic import BaseModel, ConfigDict, ValidationError
from pydantic.fields import FieldInfo

from .errors import SceneError, one_line, shown
from .fields import allowed, plain

KINDS: dict[str, list[type["Table"]]] = {}  # by name of the table: the models that it may be
MEANT = {  # other names of keys
    "q_a": "load.amplitude = Q_A/(mu P)",
    "q": "load.amplitude = Q_A/(mu P)",
    "e": "solid.E0",
    "radius": "indenter.R",
}


class Table(BaseModel):
    """One table of a scene. Made from Python as from a file: the same checks, the same SceneError."""

    model_config = ConfigDict(frozen=True, extra="forbid")
    table: ClassVar[str]  # its name
    tag: ClassVar[str] = ""  # the key whose word chooses among the models of the table
    beside: ClassVar[str] = ""  # what chooses this model, where no key has a word for it

    if not TYPE_CHECKING:  # there the fields are the arguments

        def __init__(self, **given):
            try:
                super().__init__(**given)
            except ValidationError as error:
                raise SceneError(_first_fault(type(self), error, given)) from None

    def given(self) -> dict[str, Any]:
        """The fields that were given, and the word that chooses the model."""
        names = self.model_fields_set | ({self.tag} if self.tag else set())
        return {name: value for name, value in self if name in names and value is not None}


def register(*models: type[Table]):
    """Name the models that a table may be, the default first; earlier ones are forgotten."""
    KINDS[models[0].table] = list(models)


def model_for(table: str, given: Mapping[str, Any]) -> type[Table]:
    """The model that the word of the table's ``tag`` chooses; SceneError for another word."""
    kinds = KINDS[table]
    tag = kinds[0].tag
    if tag not in given:
        return kinds[0]
    for kind in kinds:
        if kind.model_fields[tag].default == given[tag] and isinstance(given[tag], str):
            return kind
    words = allowed(*(kind.model_fields[tag] for kind in kinds))
    raise SceneError(f"{table}.{tag} = {shown(plain(given[tag]))} is not allowed: {words}")


def fields() -> dict[str, list[FieldInfo]]:
    """Every key of the tables, with its field in each model that has it."""
    found: dict[str, list[FieldInfo]] = {}
    for table, kinds in KINDS.items():
        for kind in kinds:
            for name, field in kind.model_fields.items():
                found.setdefault(f"{table}.{name}", []).append(field)
    return found


def unknown(name: str, value) -> SceneError:
    """The refusal of a key that there is not, with the one that was meant or those that there are."""
    return SceneError(
        f"{one_line(name)[:200]} = {shown(plain(value))} is not a key of the scene language: {_hint(name)}"
    )


def _hint(name: str) -> str:
    keys = ["title", *fields()]
    last = name.rpartition(".")[2].lower()
    same = {key.rpartition(".")[2].lower(): key for key in keys}.get(last)
    close = [same or MEANT.get(last, "")] if same or last in MEANT else difflib.get_close_matches(name, keys, n=1)
    if close:
        return f"did you mean {close[0]}?"
    inside = [key for key in keys if key.startswith(name.partition(".")[0] + ".")]
    return f"there are {', '.join(inside)}" if inside else f"there are title and the tables {', '.join(KINDS)}"


def _first_fault(model: type[Table], error: ValidationError, given: Mapping[str, Any]) -> str:
    """The fault to name: a wrong key before a wrong value, and that before a missing one."""
    faults: list[tuple[int, str]] = []
    for fault in error.errors(include_url=False):
        name = str(fault["loc"][0])
        key = f"{model.table}.{name}"
        if fault["type"] == "missing":
            faults.append((2, f"{key} is missing: {allowed(model.model_fields[name])}"))
        elif fault["type"] != "extra_forbidden":
            value = shown(plain(given.get(name, fault["input"])))
            faults.append((1, f"{key} = {value} is not allowed: {allowed(model.model_fields[name])}"))
        elif key in fields():
            beside = model.beside or f'{model.table}.{model.tag} = "{model.model_fields[model.tag].default}"'
            faults.append((0, f"{key} = {shown(plain(given[name]))} is not allowed beside {beside}"))
        else:
            faults.append((-1, str(unknown(key, given[name]))))
    return min(faults, key=lambda fault: fault[0])[1]
