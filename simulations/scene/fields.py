"""Types of the values in a scene: numbers with unit and range, truth values, texts, load points; what each allows.

A value is never converted silently: ``true`` is no number, ``"0.3"`` is none, 1.5 is no integer. numpy's numbers are
numbers.
"""

import json
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from types import NoneType, UnionType
from typing import Annotated, Any, Literal, Union, get_args, get_origin

from annotated_types import Ge, Gt, Le, Lt, MaxLen
from pydantic import BeforeValidator, Field
from pydantic.fields import FieldInfo

LONGEST_TEXT, LONGEST_FORMULA = 1000, 500  # characters of a text, of a formula
MOST_ON_A_LINE = 10_000  # points
LARGEST_NUMBER = 1e308  # of a number: beyond it sums overflow


@dataclass(frozen=True)
class Unit:
    """Unit of a number, for documents."""

    symbol: str


@dataclass(frozen=True)
class Word:
    """A word that may stand for a number."""

    text: str


@dataclass(frozen=True)
class ListOf:
    """What a list holds: in words for people, as a JSON schema of one item for editors; ``least`` items."""

    words: str
    item: dict[str, Any]
    least: int = 1


def plain(value):
    """numpy's scalars, and arrays of no dimension, as the Python value that they hold; anything else as it is."""
    return value.item() if getattr(value, "ndim", None) == 0 and hasattr(value, "item") else value


def is_number(value) -> bool:
    """True for finite numbers that a float holds; nan is below no number."""
    is_real = isinstance(value, (int, float)) and not isinstance(value, bool)
    return is_real and abs(value) < LARGEST_NUMBER


def _number(value) -> float:
    value = plain(value)
    if not is_number(value):
        raise ValueError("not a number")
    return float(value)


def _integer(value) -> int:
    value = plain(value)
    if not is_number(value) or value != int(value):
        raise ValueError("not an integer")
    return int(value)


def _truth(value) -> bool:
    value = plain(value)
    if not isinstance(value, bool):
        raise ValueError("not a truth value")
    return value


def _text(value) -> str:
    if not (isinstance(value, str) and value.isprintable() and len(value) <= LONGEST_TEXT):
        raise ValueError("not a text in one line")
    return str(value)


def rows(columns: int, fits: Callable[..., bool], least: int = 0) -> Callable[[Any], tuple[tuple[float, ...], ...]]:
    """Check of a list of at least so many rows of numbers, each of which ``fits`` takes."""

    def check(value):
        if hasattr(value, "tolist"):  # an array
            value = value.tolist()
        if not isinstance(value, (list, tuple)) or not all(isinstance(row, (list, tuple)) for row in value):
            raise ValueError("not a list of rows")
        found = tuple(tuple(map(_number, row)) for row in value)
        if len(found) < least or not all(len(row) == columns and fits(*row) for row in found):
            raise ValueError("too few rows, or one that does not fit")
        return found

    return check


def _is_line(x0: float, y0: float, x1: float, y1: float, n: float) -> bool:
    return min(y0, y1) >= 0 and (x0, y0) != (x1, y1) and n == int(n) and 2 <= n <= MOST_ON_A_LINE


def _words(value) -> tuple[str, ...]:
    if not isinstance(value, (list, tuple)) or not value:
        raise ValueError("not a list of names")
    return tuple(dict.fromkeys(map(_text, value)))


def _row_of(columns: int) -> dict[str, Any]:
    return {"type": "array", "items": {"type": "number"}, "minItems": columns, "maxItems": columns}


def among(known: tuple[str, ...]) -> Callable[[Any], tuple[str, ...]]:
    """Check of a list of names that each is ``known``."""

    def check(value):
        found = _words(value)
        if not set(found) <= set(known):
            raise ValueError("an unknown name")
        return found

    return check


Number = Annotated[float, BeforeValidator(_number)]
Integer = Annotated[int, BeforeValidator(_integer)]
Truth = Annotated[bool, BeforeValidator(_truth)]
Text = Annotated[str, BeforeValidator(_text), MaxLen(LONGEST_TEXT)]
FormulaText = Annotated[Text, MaxLen(LONGEST_FORMULA), Unit("m")]
Points = Annotated[
    tuple[tuple[float, float], ...],
    BeforeValidator(rows(2, lambda P, Q: P > 0, least=1)),
    Unit("N/m"),
    ListOf("a list of pairs [P, Q] of numbers, P > 0", _row_of(2)),
]
Moduli = Annotated[
    tuple[tuple[float, float], ...],
    BeforeValidator(rows(2, lambda y, E: y >= 0 and E > 0, least=2)),
    Unit("m, Pa"),
    ListOf("a list of two or more pairs [y, E] of numbers, y ≥ 0, E > 0", _row_of(2), 2),
]
Places = Annotated[
    tuple[tuple[float, float], ...],
    BeforeValidator(rows(2, lambda x, y: y >= 0)),
    Unit("m"),
    ListOf("a list of pairs [x, y] of numbers, y ≥ 0", _row_of(2), 0),
]
Lines = Annotated[
    tuple[tuple[float, float, float, float, int], ...],
    BeforeValidator(rows(5, _is_line)),
    Unit("m"),
    ListOf(
        f"a list of [x0, y0, x1, y1, n] with y ≥ 0, two different ends and an integer n, 2 ≤ n ≤ {MOST_ON_A_LINE}",
        _row_of(5),
        0,
    ),
]
StateNames = Annotated[
    tuple[str, ...], BeforeValidator(_words), ListOf('a list of states, as in ["normal", "A"]', {"type": "string"})
]
Length = Annotated[Number, Unit("m"), Field(gt=0)]
Stress = Annotated[Number, Unit("Pa"), Field(gt=0)]
LineLoad = Annotated[Number, Unit("N/m"), Field(gt=0)]
Dimensionless = Annotated[Number, Unit("–")]
Count = Annotated[Integer, Unit("–")]
Ratio = Annotated[Dimensionless, Field(gt=0)]


def alternatives(field: FieldInfo) -> Iterator[tuple[Any, list]]:
    """(type, its annotations) of every type that a field takes, None left out."""
    union = get_origin(field.annotation) in (Union, UnionType)
    for option in get_args(field.annotation) if union else (field.annotation,):
        if option is not NoneType:
            base, *own = get_args(option) if get_origin(option) is Annotated else (option,)
            marks = [*field.metadata, *own]
            yield base, [m for mark in marks for m in (mark.metadata if isinstance(mark, FieldInfo) else [mark])]


def unit(field: FieldInfo) -> str:
    """Unit of a field's number; empty where it has none."""
    return next((mark.symbol for _, marks in alternatives(field) for mark in marks if isinstance(mark, Unit)), "")


def allowed(*fields: FieldInfo) -> str:
    """What may be written for fields of one name, in words."""
    found = dict.fromkeys(text for field in fields for option in alternatives(field) for text in _in_words(*option))
    return (", or " if any("value" in text for text in found) else " or ").join(found)


def _in_words(base, marks) -> Iterator[str]:
    if get_origin(base) is Literal:
        yield from map(json.dumps, get_args(base))
    elif base is bool:
        yield "true or false"
    elif base is str:
        yield f"a text in one line of at most {longest(marks)} characters"
    elif base in (int, float):
        yield ("an integer" if base is int else "a number") + _range(marks)
    else:
        yield from (mark.words for mark in marks if isinstance(mark, ListOf))
    yield from (f'"{mark.text}"' for mark in marks if isinstance(mark, Word))


def longest(marks) -> int:
    """Characters that a text with these marks may have."""
    return min(mark.max_length for mark in marks if isinstance(mark, MaxLen))


def _range(marks) -> str:
    low = high = ""
    for mark in marks:
        match mark:
            case Gt(bound):
                low = f"{bound:g} <"
            case Ge(bound):
                low = f"{bound:g} ≤"
            case Lt(bound):
                high = f"< {bound:g}"
            case Le(bound):
                high = f"≤ {bound:g}"
    if low and not high:
        bound, sign = low.split()
        return f" {'>' if sign == '<' else '≥'} {bound}"
    return f", {low} value {high}".replace(",  value", ", value").rstrip() if low or high else ""
