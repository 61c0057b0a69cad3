"""The one-line refusal of a scene or command line, and how values are shown in it."""

from math import ceil, floor, log10
from pathlib import Path


class SceneError(Exception):
    """A scene or command line that cannot be run; the message is one line for the user.

    It is no ValueError: pydantic would take that for a fault of one field and write its own text around it.
    """


def shown(value) -> str:
    """``value`` in one line of reasonable length: as it is written, paths and messages as they are."""
    text = one_line(str(value) if isinstance(value, Path) else repr(value))
    return text if len(text) < 80 else text[:76] + " ..."


def rounded(value: float, digits: int = 1, up: bool = False) -> float:
    """A positive ``value`` to so many digits, down or up: what is advised is to be allowed."""
    unit = 10.0 ** (floor(log10(value)) + 1 - digits)
    return (ceil if up else floor)(value / unit) * unit


def one_line(text: str) -> str:
    """``text`` without what would break the line or be no character."""
    return "".join(c if c.isprintable() else "?" for c in " ".join(text.split()))
