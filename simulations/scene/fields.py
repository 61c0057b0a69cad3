"""Types of the values in a scene: numbers with unit and range, truth values, texts, load points; what each allows.

A value is never converted silently: ``true`` is no number, ``"0.3"`` is none, 1.5 is no integer. numpy's numbers are
numbers.
"""

import json
from collections.abc import Iterator
from dataclasses import dataclass
from math import isfinite
from types import NoneType, UnionType
from typing import Annotated, Any, Literal, Union, get_args, get_origin

from annotated_types import Ge, Gt, Le, Lt
from pydantic import BeforeValidator, Field
from pydantic.fields import FieldInfo

LONGEST = 1000  # characters of a text
LARGEST = 1e308  # of a number: beyond it sums overflow


@dataclass(frozen=True)
class Unit:
    """Unit of a number, for documents."""

    symbol: str


@dataclass(frozen=True)
class Word:
    """A word that may stand for a number."""

    text: str


def plain(value):
    """numpy's scalars, and arrays of no dimension, as the Python value that they hold; anything else as it is."""
    return value.item() if getattr(value, "ndim", None) == 0 and hasattr(value, "item") else value


def is_number(value) -> bool:
    """True for finite numbers that a float holds."""
    return isinstance(value, (int, float)) and not isinstance(value, bool) and abs(value) < LARGEST and isfinite(value)


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
    if not (isinstance(value, str) and value.isprintable() and len(value) <= LONGEST):
        raise ValueError("not a text in one line")
    return str(value)


def _points(value) -> tuple[tuple[float, float], ...]:
    if hasattr(value, "tolist"):  # an array
        value = value.tolist()
    pairs = isinstance(value, (list, tuple)) and all(isinstance(p, (list, tuple)) and len(p) == 2 for p in value)
    if not pairs or not value:
        raise ValueError("not a list of pairs")
    found = tuple((_number(P), _number(Q)) for P, Q in value)
    if any(P <= 0 for P, _ in found):
        raise ValueError("P is not positive")
    return found


Number = Annotated[float, BeforeValidator(_number)]
Integer = Annotated[int, BeforeValidator(_integer)]
Truth = Annotated[bool, BeforeValidator(_truth)]
Text = Annotated[str, BeforeValidator(_text)]
Points = Annotated[tuple[tuple[float, float], ...], BeforeValidator(_points), Unit("N/m")]
Length = Annotated[Number, Unit("m"), Field(gt=0)]
Stress = Annotated[Number, Unit("Pa"), Field(gt=0)]
LineLoad = Annotated[Number, Unit("N/m"), Field(gt=0)]
Ratio = Annotated[Number, Unit("–"), Field(gt=0)]


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
        yield f"a text in one line of at most {LONGEST} characters"
    elif base in (int, float):
        yield ("an integer" if base is int else "a number") + _range(marks)
    else:
        yield "a list of pairs [P, Q] of numbers, P > 0"
    yield from (f'"{mark.text}"' for mark in marks if isinstance(mark, Word))


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
