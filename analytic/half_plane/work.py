"""Frictional work of an increment, from the balance of energy on a straight way of the loads."""

from ..straight_way import StraightWay
from .interpolation import Interpolant


def worked(mu, memory, operator, solution, load, normal_stage, pressed, sheared):
    """Frictional work so far, that before the present straight way of the loads, and that way.

    pressed, sheared: pressure and traction now, each with where it moves the surface.
    """
    (p, opening), (q, place) = pressed, sheared
    friction = mu * solution.sets.slipping * (solution.pressure + memory.pressure(p.nodes)) / 2
    moved = memory.position(p.nodes) - place.value
    of_points = Interpolant.of(p.nodes, operator.of_pressure, friction).integral(moved)
    conjugates = solution.delta_y, solution.delta_x, float(operator.weight_q @ (solution.traction * q.nodes))
    before = memory.dissipated_energy
    if normal_stage or memory.way is None:
        way = StraightWay(mu, operator.is_coupled, (load,), (conjugates,))
        return before + of_points, before + of_points, way
    loss = _loss(memory.traction, memory.position, q, place)
    if operator.is_coupled:
        loss += _loss(memory.pressure, memory.gap, p, opening)
    start = memory.way.towards(load)
    begun = memory.begun if start is memory.way else before
    way = start.to(load, conjugates, loss, of_points)
    return max(begun + way.work, before), begun, way  # with more states of the way its work may be less


def _loss(traction_before: Interpolant, before, traction: Interpolant, now) -> float:
    """What a traction loses in an increment by its mean before and after; before, now: where it moves the surface."""
    parts = (part.integral(before(part.nodes) - now(part.nodes)) for part in (traction_before, traction))
    return sum(parts) / 2
