"""What a key of the scene language may hold, and the one-line refusal of anything else."""

import json
from dataclasses import dataclass
from math import inf, isfinite
from pathlib import Path
from typing import Any

LONGEST = 1000  # characters of a text


class SceneError(ValueError):
    """A scene or command line that cannot be run; the message is one line for the user."""


@dataclass(frozen=True)
class Key:
    """One key of the language: allowed range (open unless ``closed``), default (None: there is none)."""

    low: float = -inf
    high: float = inf
    default: Any = None
    kind: type = float  # float, int, bool, str, or list: of pairs (P, Q)
    closed: tuple[bool, bool] = (False, False)
    word: str | None = None  # a word that may stand for the value
    choices: tuple[str, ...] = ()  # of a text

    @property
    def allowed(self) -> str:
        """What may be written, in words."""
        left, right = ("[" if self.closed[0] else "]"), ("]" if self.closed[1] else "[")
        kinds = {
            str: " or ".join(map(json.dumps, self.choices)) or f"a text in one line of at most {LONGEST} characters",
            bool: "true or false",
            int: f"an integer in {left}{self.low:g}, {self.high:g}{right}",
            float: f"a number in {left}{self.low:g}, {self.high:g}{right}",
            list: "a list of pairs [P, Q] of numbers, P > 0",
        }
        return kinds[self.kind] + (f' or "{self.word}"' if self.word else "")

    def read(self, name: str, value):
        """``value`` as this key's type, or SceneError naming key, value and what is allowed."""
        if self.word and value == self.word:
            return value
        readers = {str: self._text, bool: self._truth, int: self._number, float: self._number, list: self._pairs}
        read = readers[self.kind](value)
        if read is None:
            raise SceneError(f"{name} = {shown(value)} is not allowed: {self.allowed}")
        return read

    def _text(self, value):
        good = isinstance(value, str) and (not self.choices or value in self.choices)
        return value if good and value.isprintable() and len(value) <= LONGEST else None

    def _truth(self, value):
        return value if isinstance(value, bool) else None

    def _number(self, value):
        if not is_number(value) or (self.kind is int and value != int(value)):
            return None
        above = value >= self.low if self.closed[0] else value > self.low
        below = value <= self.high if self.closed[1] else value < self.high
        return self.kind(value) if above and below else None

    def _pairs(self, value):
        pairs = isinstance(value, list) and value and all(isinstance(p, list) and len(p) == 2 for p in value)
        if not pairs or not all(is_number(P) and is_number(Q) and P > 0 for P, Q in value):
            return None
        return [[float(P), float(Q)] for P, Q in value]


def is_number(value) -> bool:
    """True for finite numbers that a float holds."""
    return isinstance(value, (int, float)) and not isinstance(value, bool) and abs(value) < 1e308 and isfinite(value)


def shown(value) -> str:
    """``value`` in one line of reasonable length: as it is written, paths and messages as they are."""
    text = one_line(str(value) if isinstance(value, Path) else repr(value))
    return text if len(text) < 80 else text[:76] + " ..."


def one_line(text: str) -> str:
    """``text`` without what would break the line or be no character."""
    return "".join(c if c.isprintable() else "?" for c in " ".join(text.split()))
