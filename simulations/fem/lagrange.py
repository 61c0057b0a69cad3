"""Nodes, weights and polynomials of a Lagrange element."""

import numpy as np

LOBATTO = {  # nodes of a facet but the last, the first of the next one, and their weights there; by degree
    1: ((0.0,), (1.0,)),
    2: ((0.0, 0.5), (1 / 3, 2 / 3)),
    3: ((0.0, (1 - 5**-0.5) / 2, (1 + 5**-0.5) / 2), (1 / 6, 5 / 12, 5 / 12)),
}


def lagrange(nodes: np.ndarray, t: np.ndarray) -> np.ndarray:
    """Values (n, m) at ``t`` (n,) of the polynomials that are 1 at one of the ``nodes`` (m,) and 0 at the others."""
    values = np.ones((len(t), len(nodes)))
    for i, node in enumerate(nodes):
        for other in np.delete(nodes, i):
            values[:, i] *= (t - other) / (node - other)
    return values


def gauss(count: int) -> tuple[np.ndarray, np.ndarray]:
    """Gauss points on 0 ... 1 and their weights (count,)."""
    nodes, weights = np.polynomial.legendre.leggauss(count)
    return (nodes + 1.0) / 2.0, weights / 2.0
