"""The load schedule: every load step with its loads, branch and state name, in order."""

from dataclasses import dataclass, replace

import numpy as np


@dataclass(frozen=True)
class Increment:
    """One load level: line loads (dimensionless), the branch it lies on, and a letter for the paper's states."""

    P: float
    Q: float = 0.0
    branch: str = "normal"  # normal, initial, unloading, reloading; path between given points
    state: str = ""  # A ... E of Figure 11; 1, 2, ... at given points
    cycle: int = 0
    direction: int = 0  # in which Q moves

    @property
    def load(self) -> tuple[float, float]:
        """Line loads as (Q, P)."""
        return self.Q, self.P


def pressing(P: float, increments: int = 1) -> list[Increment]:
    """The normal stage: P in steps of equal contact half-width, roughly."""
    return [Increment(P * (i / increments) ** 2) for i in range(1, increments + 1)]


def rocking(P: float, Q_A: float, cycles: int, quarter: int) -> list[Increment]:
    """To +Q_A, then ``cycles`` times to -Q_A and back, ``quarter`` increments per Q_A.

    States of Figure 11: A = +Q_A, B = +Q_A/2 on the way down, C = 0, D = -Q_A/2, E = -Q_A. B and D are marked on the
    nearest increments.
    """
    ramp = np.arange(1, quarter + 1) / quarter
    swing = np.arange(1, 2 * quarter + 1) / quarter
    programme = [Increment(P, Q_A * z, "initial", direction=1) for z in ramp]
    programme[-1] = replace(programme[-1], state="A")
    for cycle in range(1, cycles + 1):
        down = [Increment(P, Q_A * (1 - z), "unloading", cycle=cycle, direction=-1) for z in swing]
        for state, share in (("B", 0.25), ("C", 0.5), ("D", 0.75), ("E", 1.0)):
            i = round(share * 2 * quarter) - 1
            if i >= 0:
                down[i] = replace(down[i], state=state)
        up = [Increment(P, -Q_A * (1 - z), "reloading", cycle=cycle, direction=1) for z in swing]
        up[-1] = replace(up[-1], state="A")
        programme += down + up
    return programme


def visiting(start: tuple[float, float], points: list[tuple[float, float]], increments: int) -> list[Increment]:
    """Straight from point to point (P, Q), ``increments`` each; pressing goes on while Q has not moved yet."""
    programme, branch = [], "normal"
    for number, (P, Q) in enumerate(points, start=1):
        if Q != 0:
            branch = "path"
        direction = int(np.sign(Q - start[1]))
        for z in np.arange(1, increments + 1) / increments:
            load = [before + z * (after - before) for before, after in zip(start, (P, Q))]
            programme.append(Increment(load[0], load[1], branch, direction=direction))
        programme[-1] = replace(programme[-1], state=str(number) if branch == "path" else "")
        start = P, Q
    return programme
