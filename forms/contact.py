"""Frictional contact with the rigid indenter, in Nitsche's form: the pieces of weak_form.Contact.

The contact conditions p >= 0, gap >= 0, p gap = 0 and |q| <= mu p with slip against q are equalities:

    p = [ t_y(u) - gamma gap(u) ]_+
    q = clip( t_x(u) - gamma (s(u) - s_anchor), -mu p, mu p )

for any gamma > 0, with t(u) the traction of the displacement field and s = u_x - delta_x the
displacement relative to the indenter. Nitsche's method puts these right-hand sides into the weak form as
surface tractions. ``s_anchor`` is where a point last came to rest; it is moved after each increment
by ``rest_position`` (a return mapping), so that an increment without load changes nothing.
"""

import ufl

X, Y = 0, 1  # components: along the surface, into the body
OPEN, BACKWARD, CLOSED, FORWARD = 0, 1, 2, 3  # contact states: sliding along -x, closed or stuck, sliding along +x
# Imposed on a point whatever its tractions are, in ``slides`` and ``contact_pressure``: it slides along -x, does not
# slide, slides along +x, is open; 0 imposes nothing.
DRIVEN_BACKWARD, PINNED, DRIVEN_FORWARD, LIFTED = -1.0, 1.0, 2.0, 3.0


def gap(u, profile, delta):
    """Normal distance  f(x) + u_y - delta_y  between surface and indenter; negative is overlap."""
    return profile + u[Y] - delta[Y]


def relative_displacement(u, delta):
    """Tangential displacement  s = u_x - delta_x  of the surface relative to the indenter."""
    return u[X] - delta[X]


def stretch(strain, x):
    """What a uniform strain of the body adds to s:  eps x , [X7]; it does no work on the deviation u from it."""
    return strain * x


def trial_pressure(traction, gap, gamma):
    """The pressure of a point that stays in contact:  t_y - gamma gap ."""
    return traction[Y] - gamma * gap


def contact_pressure(trial, imposed=None):
    """p = [ trial ]_+ ; imposed: as in ``slides``: a point that is LIFTED has no pressure; None: nothing is."""
    touches = ufl.gt(trial, 0.0)
    if imposed is not None:
        touches = ufl.And(touches, ufl.lt(imposed, (DRIVEN_FORWARD + LIFTED) / 2))
    return ufl.conditional(touches, trial, 0.0)


def clearance(traction, gap, gamma):
    """How far a point is from touching, a length:  [ gap - t_y / gamma ]_+ ; zero in contact."""
    distance = gap - traction[Y] / gamma
    return ufl.conditional(ufl.gt(distance, 0.0), distance, 0.0)


def trial_traction(traction, s, anchor, gamma, elastic=None):
    """The tangential traction of a point that does not slip:  [t_x - gamma (s - s_anchor)]/(1 + gamma c) .

    elastic: compliance c of elastic slip, with which a stuck point moves by  s - s_anchor = -c q ; None: c = 0.
    """
    trial = traction[X] - gamma * (s - anchor)
    return trial if elastic is None else trial / (1.0 + gamma * elastic)


def slides(trial, limit, imposed):
    """Where a point slides: 1 along +x, -1 along -x, 0 where it sticks.

    imposed: what a Newton step imposes on it, see PINNED; 0 everywhere for Coulomb's law as it is.
    """
    free = ufl.lt(abs(imposed), 0.5)
    forward = ufl.Or(ufl.And(free, ufl.gt(trial, limit)), ufl.gt(imposed, (PINNED + DRIVEN_FORWARD) / 2))
    backward = ufl.Or(ufl.And(free, ufl.lt(trial, -limit)), ufl.lt(imposed, DRIVEN_BACKWARD / 2))
    return ufl.conditional(forward, 1.0, ufl.conditional(backward, -1.0, 0.0))


def coulomb(trial, pressure, limit, sliding):
    """Coulomb's projection  q = clip(trial, -mu p, mu p), (25), (26); limit: mu p; sliding: from ``slides``."""
    projected = ufl.conditional(ufl.gt(abs(sliding), 0.5), sliding * limit, trial)
    return ufl.conditional(ufl.gt(pressure, 0.0), projected, 0.0)


def contact_state(pressure, sliding=None):
    """OPEN, CLOSED, FORWARD or BACKWARD as a number; sliding: from ``slides``, None without friction."""
    closed = ufl.conditional(ufl.gt(pressure, 0.0), float(CLOSED), float(OPEN))
    return closed if sliding is None else ufl.conditional(ufl.gt(closed, 1.0), closed + sliding, 0.0)


def rest_position(traction, s, q, gamma, elastic=None):
    """The anchor after an increment that ended with traction ``q``:  s - (t_x - q)/gamma + c q.

    Unchanged where the point stuck; where it slid, the position from which ``q`` is the trial value. elastic: c, as in
    ``trial_traction``.
    """
    rest = s - (traction[X] - q) / gamma
    return rest if elastic is None else rest + elastic * q


def work(contact_traction, v, direction):
    """Integrand of the virtual work of one contact traction:  ∫ p v_y dx  or  ∫ q v_x dx."""
    return contact_traction * v[direction]


def consistency(traction, contact_traction, traction_test, theta, gamma):
    """Integrand of Nitsche's  theta ∫ (t(u) - p) t(v) / gamma dx , which vanishes at the solution.

    theta = 1 makes the frictionless form symmetric, 0 drops the term, -1 makes it skew.
    """
    return theta / gamma * (traction - contact_traction) * traction_test
