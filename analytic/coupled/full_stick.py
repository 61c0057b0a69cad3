"""Compliance of a contact that sticks everywhere: how far the indenter moves with Q just after a turn."""

import numpy as np
from scipy.special import loggamma

from .exponents import oscillation

STEP, REACH = 0.05, 6.0  # of the double exponential rule


def stick_compliance(problem, half):
    """d delta_x / dQ at constant P while the contact of half-width ``half`` sticks everywhere, in units of ``Problem``.

    With D = d/sqrt(bk gk) the rates phi = sqrt(bk/gk) dp/dQ + i dq/dQ make R*phi + i D O*phi constant. As with friction
    (``exponents.edge_exponent``), which is imaginary here, phi is i C (1+t)^(e-1) (1-t)^(conj(e)-1), with
    e = (1+k)/2 + i epsilon (``exponents.oscillation``); C from the integral of phi. delta_x is u_x in the middle.
    """
    k = problem.k
    D = problem.d / np.sqrt(problem.bk * problem.gk)
    epsilon = oscillation(k, problem.bk, problem.gk, problem.d)
    exponent = (1 + k) / 2 + 1j * epsilon
    C = 2**-k * np.exp(loggamma(1 + k) - 2 * loggamma(exponent).real)
    # t = tanh s, and s = exp(y - exp(-y)): the ends of 0 < s become regular
    y = np.arange(-REACH, REACH, STEP)
    s = np.exp(y - np.exp(-y))
    weight = STEP * s * (1 + np.exp(-y)) * np.cosh(s) ** -(1 + k)
    log = np.log(half * np.tanh(s))
    even = np.expm1(-k * log) / k if k else -log
    of_q = problem.gk * (weight @ (even * np.cos(2 * epsilon * s)))
    of_p = problem.gk * D * (weight @ (np.exp(-k * log) * np.sin(2 * epsilon * s)))
    return float(2 * C * (of_q + of_p))
