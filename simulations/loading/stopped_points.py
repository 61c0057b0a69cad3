"""Anchors of points that slide and come to rest within a load step: they lie on the curve that the edge of stick draws.

Where it is after the step the edge tells where points stop, and so do points that stuck before. Points between these
stopped one after the other, and where each did is a smooth function of x.
"""

import numpy as np

from forms.contact import CLOSED, OPEN

from .contact_points import BESIDE, SAME, Surface, edge_of_contact, leading

CUT = 4  # points that reach over the facet which an edge of contact cuts
OUT = 2  # points outside of that facet which are anchored with those that it reaches over
DRAWN = 0.3  # least length of an edge's curve up to now, over that in this step, from which it goes on
SLIVER = 0.06  # least width of a band of slip that an edge of stick draws through, over how far that of contact came
FOLLOWS = 2.0  # times as far as the edge of contact that of stick goes which follows it; further it goes in a reversal


def anchors_of_stopped(x, before: Surface, after: Surface, side: int, touch, start: float) -> tuple:
    """Indices and anchors of points that stick now but slid before, or were open, as those beyond them slide now.

    They lie on one side of the contact, from the edge of stick inwards. Where it is now the edge tells where points
    stop, and so do those that stuck before: the anchors between lie on a smooth curve through both, where the edge has
    drawn one since ``start`` (nan: it has not), or begins to as it leaves the old edge of contact. Else points go on
    from where they were, or ``touch`` (n,), the further the closer they are to the edge. Third: from where on there is
    a curve now; nan without points.
    """
    contact = np.flatnonzero(after.states != OPEN)
    outwards = contact if side > 0 else contact[::-1]
    states, old = after.states[outwards], before.states[outwards]
    sliding = leading(states[::-1] == states[-1]) if states[-1] != CLOSED else 0
    edge = len(outwards) - sliding
    new = (old == OPEN) | (old == states[-1])  # some may slide still, for no other reason than their old anchors
    first = edge - leading(new[:edge][::-1])
    none = outwards[:0], np.zeros(0), np.nan
    if not sliding or sliding == len(outwards) or first == edge or states[edge - 1] != CLOSED:
        return none
    stopped, outer = outwards[first:edge], outwards[edge]

    def joined(first):  # cubic through points on both sides of those from ``first`` to the edge
        inside, outside = outwards[max(first - 1 - BESIDE, 0)], outwards[edge + min(BESIDE, sliding // 2)]
        stopped = outwards[first:edge]
        return stopped, smooth(x, after.s, [inside, outwards[first - 1], outer, outside], x[stopped])

    if np.all(before.states == OPEN):  # the contact started from a point, under an indenter that is a power there
        tip = float(x[np.argmin(before.clearance)])
        share = before.clearance / before.clearance[outer]
        stopped = stopped[side * x[stopped] > side * tip]
        return stopped, after.s[outer] * share[stopped], tip
    was = x[before.states != OPEN]
    moved = abs(x[outwards[-1]] - (was[-1] if side > 0 else was[0]))
    if abs(edge_of_contact(x, after.states, side) - (x[outer] + x[outwards[edge - 1]]) / 2) < SLIVER * moved:
        return none  # it sticks up to its edge, but for what the facet there makes of it
    still = edge - leading(states[:edge][::-1] == CLOSED)
    slides_back = leading(states[first:still][::-1] == 2 * CLOSED - states[-1]) > CUT
    if slides_back and abs(x[outwards[still]] - x[outer]) < moved:  # what slid soon slides the other way
        band, positions = joined(still)
        share = 1.0 - np.abs(x[outwards[first:still]] - x[band[0]]) / moved  # > 0 where the band passed
        back, share = outwards[first:still][share > 0], share[share > 0]
        positions = np.append(touch[back] + share * (positions[0] - touch[band[0]]), positions)
        return np.append(back, band), positions, start
    passed = np.count_nonzero(old[first:edge] == OPEN)  # by the edge of contact
    reverses = edge - first > passed and abs(x[stopped[-1]] - x[stopped[0]]) > FOLLOWS * moved
    if reverses and passed == 0:  # what slid stops where it is
        return none
    begins = reverses or np.isnan(start) and passed >= edge - first - CUT
    if begins:
        first = max(edge - passed - CUT, 0)
    if first == 0:
        return none
    inner = outwards[first - 1]
    if begins:
        return *joined(first), float(x[inner])
    length, drawn = abs(x[outer] - x[inner]), side * (x[inner] - start)
    if not drawn >= DRAWN * length:
        share = (x[stopped] - x[inner]) / (x[outer] - x[inner])
        began = start if np.isfinite(start) else float(x[inner])
        return stopped, touch[stopped] + (after.s[outer] - touch[outer]) * share, began
    behind = outwards[np.argmin(np.abs(x[outwards] - (x[inner] - side * min(length, drawn))))]
    return stopped, smooth(x, after.s, [behind, inner, outer], x[stopped]), start


def without_kink(x, before: Surface, after: Surface, side: int, touch) -> np.ndarray:
    """``touch`` (n,), but smooth where the edge of contact was before the step, if it has gone on.

    The facet that it cut let points slide beside it, and moved those beyond it: where they stop they would keep that.
    Points that slid there, at most ``CUT``, lie on a smooth curve through those further inside and further out.
    """
    contact = np.flatnonzero(after.states != OPEN)
    outwards = contact if side > 0 else contact[::-1]
    old = before.states[outwards]
    was = len(old) - leading(old[::-1] == OPEN)
    first, end = was - min(leading(old[:was][::-1] != CLOSED), CUT), was + OUT
    inner, outer = first - 1 - BESIDE, end + BESIDE
    if first == was or inner < 0 or outer >= len(old):
        return touch
    smoothed = touch.copy()
    smoothed[outwards[first:end]] = smooth(x, touch, outwards[[inner, first - 1, end, outer]], x[outwards[first:end]])
    return smoothed


def smooth(x, values, support: list | np.ndarray, at) -> np.ndarray:
    """At points ``at`` the polynomial through those ``values`` of points (n,) at x that ``support`` lists."""
    nodes = np.sort(x[support])
    nodes = nodes[np.diff(nodes, prepend=-np.inf) > SAME]
    return np.polynomial.Polynomial.fit(nodes, values[np.searchsorted(x, nodes)], len(nodes) - 1)(at)
