"""The complete problem on one page. docs/method.md has the same in mathematics, with the same numbers (F1) ... (F12).

Unknowns: the displacement u of the body, in the mixed form also its mean stress pi, and the rigid displacement
delta = (delta_x, delta_y) of the indenter. For all test functions v (and r), under the line loads P and Q:

    (F1) + (F2) - (F8) - (F9) = 0,      resultants (F10) = (Q, P)

    plain displacements    (F1)          mixed                (F1), (F2)
    frictionless           p by (F5), no q
    frictional             p by (F5), q by (F7)
    held pressure          p = p_N, held from the frictionless problem; q by (F7), with u - u_N for u in t and s
    theta = 0              no (F9)
"""

from dataclasses import dataclass, field
from typing import Any

import ufl

from . import contact, elasticity
from .contact import X, Y
from .elasticity import Solid


def internal_work(solid: Solid, u, pi, v, r, dx):
    """Virtual work of the stresses; in the mixed form also what makes ``pi`` the mean stress. pi, r: None if plain."""
    work = elasticity.virtual_work(solid, u, v, pi) * dx  # (F1)
    if pi is not None:
        work += elasticity.dilatation(solid, u, pi, r) * dx  # (F2)
    return work


def surface_traction(solid: Solid, u, pi):
    """t = sigma n on the surface, n the outward normal."""
    return elasticity.surface_traction(solid, u, pi)  # (F3)


@dataclass(frozen=True)
class Friction:
    """What Coulomb's law needs beside the displacement: constants and fields at the surface points.

    mu; anchor: where a point last came to rest; imposed: contact states that a Newton step imposes
    (``contact.slides``), 0 for none; stretch: tangential displacement of the surface beside u (``contact.stretch``),
    None without bulk strain; elastic: compliance of elastic slip, a length over a stress, None without.
    """

    mu: Any
    anchor: Any
    imposed: Any
    stretch: Any = None
    elastic: Any = None


@dataclass(frozen=True)
class NitscheParameters:
    """gamma > 0, a stress over a length, and theta; None for theta = 0, which drops (F9)."""

    gamma: Any
    theta: Any = None


@dataclass(frozen=True)
class Contact:
    """The contact tractions ``tractions[Y]`` = p and ``tractions[X]`` = q, and what else is known at a surface point.

    trials: what p and q would be if the point stayed in contact and stuck, each linear in the displacements; state:
    ``contact.contact_state``; clearance: None where the pressure is held; rest, released: None without friction.
    """

    t: Any
    nitsche: NitscheParameters
    tractions: dict[int, Any] = field(default_factory=dict)
    trials: dict[int, Any] = field(default_factory=dict)
    state: Any = None
    clearance: Any = None
    friction: Friction | None = None
    rest: Any = None
    released: Any = None


def frictionless_contact(u, t, delta, profile, nitsche: NitscheParameters, imposed=None) -> Contact:
    """Pressure alone, (F5); profile: the indenter's f(x); imposed: as in ``contact.contact_pressure``."""
    g = contact.gap(u, profile, delta)  # (F4)
    trial = contact.trial_pressure(t, g, nitsche.gamma)
    p = contact.contact_pressure(trial, imposed)  # (F5)
    return Contact(t, nitsche, {Y: p}, {Y: trial}, contact.contact_state(p), contact.clearance(t, g, nitsche.gamma))


def frictional_contact(u, t, delta, profile, nitsche: NitscheParameters, friction: Friction) -> Contact:
    """Pressure and tangential traction, (F5) and (F7)."""
    normal = frictionless_contact(u, t, delta, profile, nitsche, friction.imposed)
    return _with_friction(u, t, delta, normal.tractions[Y], normal, nitsche, friction)


def tangential_contact(u, t, delta, held_pressure, nitsche: NitscheParameters, friction: Friction) -> Contact:
    """Tangential traction alone, (F7), under a held pressure p_N; u and t: less those of the frictionless problem."""
    normal = Contact(t, nitsche, trials={Y: held_pressure})
    return _with_friction(u, t, delta, held_pressure, normal, nitsche, friction)


def _with_friction(u, t, delta, p, normal, nitsche, friction):
    gamma, limit = nitsche.gamma, friction.mu * p
    s = contact.relative_displacement(u, delta)  # (F6)
    if friction.stretch is not None:
        s += friction.stretch  # (F6)
    trial = contact.trial_traction(t, s, friction.anchor, gamma, friction.elastic)
    sliding = contact.slides(trial, limit, friction.imposed)
    q = contact.coulomb(trial, p, limit, sliding)  # (F7)
    return Contact(
        t,
        nitsche,
        normal.tractions | {X: q},
        normal.trials | {X: trial},
        contact.contact_state(p, sliding),
        normal.clearance,
        friction,
        rest=contact.rest_position(t, s, q, gamma, friction.elastic),  # (F11)
        released=contact.rest_position(t, s, 0.0, gamma),
    )


def contact_work(law: Contact, v, ds):
    """Virtual work of the contact tractions."""
    return sum(contact.work(traction, v, i) * ds for i, traction in law.tractions.items())  # (F8)


def contact_forces(law: Contact, state, test, v, ds):
    """All contact terms: the virtual work and, for theta other than 0, Nitsche's consistency term.

    state: the field of all unknowns of the body, with ``test`` its test function and v that of the displacement.
    """
    forces = contact_work(law, v, ds)
    if law.nitsche.theta is not None:
        for i, traction in law.tractions.items():
            t_test = ufl.derivative(law.t[i], state, test)
            forces += contact.consistency(law.t[i], traction, t_test, law.nitsche.theta, law.nitsche.gamma) * ds  # (F9)
    return forces


def resultants(law: Contact, ds, symmetry_factor: float):
    """∫ q dx and ∫ p dx of the whole body, in the order of their directions; symmetry_factor: 2 on half a body."""
    return [symmetry_factor * law.tractions[i] * ds for i in sorted(law.tractions)]  # (F10)


def contact_tangent(forces, state, trial):
    """What the contact terms add to the Jacobian by the state."""
    return ufl.derivative(-forces, state, trial)  # (F12)


def rigid_borders(forces, loads, state, test, translations):
    """Columns, rows and corner of the Jacobian for the rigid displacements; forces, loads: (F8) + (F9), and (F10).

    The indenter enters through u - delta alone: d/d(delta_i) is minus the derivative along the translation e_i.
    """
    columns = [ufl.derivative(forces, state, e) for e in translations]  # (F12)
    rows = [ufl.derivative(load, state, test) for load in loads]
    corner = [[-ufl.derivative(load, state, e) for e in translations] for load in loads]
    return columns, rows, corner
