"""Compliance of a contact that sticks everywhere: how far the indenter moves with Q just after a turn."""

import numpy as np
from scipy.special import digamma, loggamma

from .exponents import oscillation
from .panels import gauss

SMALL_K, NODES = 0.5, 24  # |k| below which ln Γ(z - k) - ln Γ(z) is integrated, as it would cancel; nodes for that


def stick_compliance(problem, half):
    """d delta_x / dQ at constant P while the contact of half-width ``half`` sticks everywhere, in units of ``Problem``.

    With D = d/sqrt(bk gk) the rates phi = sqrt(bk/gk) dp/dQ + i dq/dQ make R*phi + i D O*phi constant. As with friction
    (``exponents.edge_exponent``), which is imaginary here, phi is i C (1+t)^(e-1) (1-t)^(conj(e)-1), with
    e = (1+k)/2 + i epsilon (``exponents.oscillation``); C from the integral of phi. delta_x is u_x at the right edge,
    where the integrals are beta functions: with s = e^(kG) = (2 half)^-k Γ(1+k) Γ(conj(e)-k)/Γ(conj(e)) it is
    gk [(Re s - 1)/k - D Im s].
    """
    k = problem.k
    D = problem.d / np.sqrt(problem.bk * problem.gk)
    conjugate = (1 + k) / 2 - 1j * oscillation(k, problem.bk, problem.gk, problem.d)
    if abs(k) < SMALL_K:
        t, weight = gauss(NODES)
        G = (weight / 2) @ (digamma(1 + k * (1 + t) / 2) - digamma(conjugate - k * (1 + t) / 2))
    else:
        G = (loggamma(1 + k) + loggamma(conjugate - k) - loggamma(conjugate)) / k
    G -= np.log(2 * half)
    even = np.expm1(k * G).real / k if k else G.real
    return float(problem.gk * (even - D * np.exp(k * G).imag))
