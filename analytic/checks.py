"""Errors, and checks of input: every refusal names the value and the admissible range."""

from math import inf


class UndefinedDisplacementError(ValueError):
    """A displacement was asked for that does not exist for k <= 0."""


class ContactNotConverged(RuntimeError):
    """The contact problem was not solved; the message says what was still changing."""


def require(name, value, low=0.0, high=inf, *, closed_low=False, closed_high=False):
    """Raise ValueError unless low < value < high, or <= where closed; a limit that is infinite is open."""
    above = value >= low if closed_low else value > low
    below = value <= high if closed_high else value < high
    if not (above and below):
        left, right = "<=" if closed_low else "<", "<=" if closed_high else "<"
        raise ValueError(
            f"{name} = {value!r} is outside the admissible range {low} {left} {name} {right} {high}"
        )


def require_partial_slip(P, Q, mu):
    """Raise ValueError unless 0 < P < inf, 0 <= mu < inf, and |Q| < mu P, where Q = 0 needs no friction."""
    require("mu", mu, closed_low=True)
    if not P > 0 or not (Q == 0 or abs(Q) < mu * P):
        raise ValueError(f"P = {P!r}, Q = {Q!r}: needs P > 0 and |Q| < mu P, mu = {mu!r}")
    require("P", P)


def require_positive_k(k, quantity):
    """Raise UndefinedDisplacementError for k <= 0, where displacements do not decay at infinity."""
    if k <= 0:
        raise UndefinedDisplacementError(
            f"{quantity} does not exist for k = {k!r}: for k <= 0 the displacement of a loaded "
            "half-plane grows without bound with the distance, so that only relative displacements "
            "are defined; 0 < k < 1 is required"
        )
