"""The load schedule: every load step with its loads, branch and state name, in order."""

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from ..fem.load import NO_LOAD, Load

SHORT = np.pi / 480  # longest last load step before a turn, on an ellipse of loads; a load of all runs lies there


@dataclass(frozen=True)
class LoadStep:
    """A load to be reached, the branch it lies on, and a letter for the paper's states."""

    load: Load
    branch: str = "normal"  # normal, initial, unloading, reloading; path between given points
    state: str = ""  # A ... E of Figure 11; 1, 2, ... at given points
    cycle: int = 0
    direction: int = 0  # in which Q moves
    angle: float = 0.0  # by which Q and strain, cosines with a lag, have gone round since the step before; 0: straight

    @property
    def P(self) -> float:
        """Normal line load."""
        return self.load.P

    @property
    def Q(self) -> float:
        """Tangential line load."""
        return self.load.Q

    def on_the_way(self, before: Load, share: float) -> Load:
        """Load after this share of the way from the load ``before``."""
        if not self.angle:
            return before.towards(self.load, share)
        of_before, of_this = np.sin(np.array([1 - share, share]) * self.angle) / np.sin(self.angle)
        strain = of_before * before.strain + of_this * self.load.strain
        return Load(self.P, of_before * before.Q + of_this * self.Q, strain)


def pressing(P: float, steps: int = 1, power: float = 2.0) -> list[LoadStep]:
    """The normal stage: P in steps of equal contact half-width a, P proportional to a^power."""
    return [LoadStep(Load(P * (i / steps) ** power)) for i in range(1, steps + 1)]


def rocking(P: float, Q_A: float, cycles: int, quarter: int, harmonic: bool = False) -> list[LoadStep]:
    """To +Q_A, then ``cycles`` times to -Q_A and back, ``quarter`` load steps per Q_A.

    harmonic: the steps of a cycle are equal in the angle of Q = Q_A cos(angle), not in Q. One step more ends SHORT
    before each turn: strain that lags stops points just before the turn, which still slide in a long step.
    States of Figure 11: A = +Q_A, B = +Q_A/2 on the way down, C = 0, D = -Q_A/2, E = -Q_A. B and D are marked on the
    nearest load steps.
    """
    ramp = np.arange(1, quarter + 1) / quarter
    swing = np.arange(1, 2 * quarter + 1) / quarter
    angles = np.zeros(len(swing))
    if harmonic:
        near = 2 - SHORT * 2 / np.pi
        if not np.isclose(swing, near, rtol=0, atol=1e-9).any():
            swing = np.sort(np.append(swing, near))
        angles = np.diff(swing, prepend=0.0) * np.pi / 2
        swing = 1 - np.sin(np.pi / 2 * (1 - swing))  # 1 where Q passes zero, to the last digit
    schedule = [LoadStep(Load(P, Q_A * z), "initial", direction=1) for z in ramp]
    schedule[-1] = replace(schedule[-1], state="A")
    for cycle in range(1, cycles + 1):
        down = [LoadStep(Load(P, Q_A * (1 - z)), "unloading", "", cycle, -1, angle) for z, angle in zip(swing, angles)]
        for state, z in (("B", 0.5), ("C", 1.0), ("D", 1.5), ("E", 2.0)):
            i = round(np.interp(z, [0.0, *swing], np.arange(len(swing) + 1))) - 1
            if i >= 0:
                down[i] = replace(down[i], state=state)
        up = [LoadStep(Load(P, Q_A * (z - 1)), "reloading", "", cycle, 1, angle) for z, angle in zip(swing, angles)]
        up[-1] = replace(up[-1], state="A")
        schedule += down + up
    return schedule


def stretched(schedule: list[LoadStep], strain: float, phase: float | str) -> list[LoadStep]:
    """The steps of ``rocking`` (and those before) with the strain of the body: ``strain`` cos(angle - phase).

    The angle is that of Q = Q_A cos(angle) on its way round the cycle; before, the strain grows with Q. phase: degrees
    by which the strain lags behind Q, or "constant" from +Q_A on.
    """
    Q_A = max(step.Q for step in schedule)
    lag = 0.0 if phase == "constant" else np.deg2rad(float(phase))

    def share(step):
        Q = step.Q / Q_A
        if not step.cycle:
            return Q * np.cos(lag)
        if phase == "constant":
            return 1.0
        return Q * np.cos(lag) - step.direction * np.sqrt(max(1 - Q**2, 0.0)) * np.sin(lag)

    return [replace(step, load=step.load._replace(strain=strain * share(step))) for step in schedule]


def visiting(start: Load, points: list[Load], steps: int) -> list[LoadStep]:
    """Straight from point to point, ``steps`` each; pressing goes on while Q has not moved yet."""
    schedule, branch, direction = [], "normal", 0
    for number, point in enumerate(points, start=1):
        if point.Q != 0:
            branch = "path"
        if not start.is_near(point):  # a dwell is no turn
            direction = int(np.sign(point.Q - start.Q))
        for z in np.arange(1, steps + 1) / steps:
            schedule.append(LoadStep(start.towards(point, z), branch, direction=direction))
        # the point to its last digit: without coupling nothing enters contact while P stays
        schedule[-1] = replace(schedule[-1], load=point, state=str(number) if branch == "path" else "")
        start = point
    return schedule


def pressed_first(schedule: Sequence[LoadStep]) -> int:
    """How many load steps, from the first, do nothing but press further, or dwell."""
    loads = [NO_LOAD, *(step.load for step in schedule)]
    others = (n for n, (a, b) in enumerate(zip(loads, loads[1:])) if any(b[1:]) or b.P < a.P and not b.is_near(a))
    return next(others, len(schedule))


def load_parameter(schedule: Sequence[LoadStep]) -> np.ndarray:
    """Length of the load path up to each step (s,), in the largest P and the largest Q: of a loop 1 at the end of the
    normal stage, 2 at the first +Q_A, 4 at -Q_A and 6 at +Q_A again.
    """
    loads = np.array([(0.0, 0.0), *((step.P, step.Q) for step in schedule)])
    largest = np.abs(loads).max(axis=0)
    moves = np.abs(np.diff(loads, axis=0)) / np.where(largest > 0, largest, 1.0)
    return np.cumsum(moves.sum(axis=1))
