"""The defining integrals of power-law graded contact as printed, evaluated with mpmath.

Nothing here uses a closed form of the package. Numbers in brackets are the equations of Heß, Giesa,
Riechert, Wilhayn, Appl. Sci. 2026, 16(1), 473; [X1] ... [X5] mark results beyond the paper.
k = 0, where b and g have a pole, is taken as k = 1e-30 with the digits to spare.
"""

from functools import lru_cache

import mpmath as mp

DIGITS = 42
mp.mp.dps = DIGITS + 40  # b, g and the kernel of (8) cancel to order k, i.e. 30 digits at k = 0

EXPONENTS = [-0.99, -0.9, -0.5, -1e-3, -1e-8, -1e-12, 0.0, 1e-12, 1e-8, 1e-3, 0.5, 0.9, 0.99]
SELECTED = [-0.99, -0.5, -1e-12, 0.0, 1e-8, 0.5, 0.99]  # for the slower integrals
EPS = 2.0**-52


def relative_error(value, exact):
    """|value/exact - 1| of a float against an mpmath number, absolute if exact is 0."""
    value = mp.mpf(float(value))
    return float(abs(value - exact) / abs(exact)) if exact else float(abs(value))


def nonzero(k):
    return mp.mpf(k) if k else mp.mpf("1e-30")


def integrate(f, length, left=0, right=0, digits=DIGITS):
    """∫_0^length f(u, length-u) du, f ~ u^left and ~ (length-u)^right at the ends."""
    with mp.workdps(digits):
        half = mp.mpf(length) / 2

        def part(power, g):
            m = 1 / (1 + mp.mpf(min(power, 0)))
            return mp.quad(lambda v: g(half * v**m) * half * m * v ** (m - 1), [0, 1])

        return part(left, lambda u: f(u, length - u)) + part(right, lambda u: f(length - u, u))


def kernel_displacement(k, compliance, traction, x, a, edge):
    """u(0) - u(x) from kernel (2): compliance/k ∫ traction(xi) (|xi|^-k - |x-xi|^-k) dxi, |xi| < a.

    compliance = (bk) y0^k/E0 or (gk) y0^k/E0; the traction is even, traction(u, a-u) for u = |xi|,
    of order (a - u)^edge; x > 0.
    """
    digits = DIGITS + (40 if abs(k) < 1e-3 else 0)  # the integrals cancel to order k

    def part(f, length, left=0, right=0):
        return integrate(f, length, left, right, digits)

    total = 2 * part(lambda u, d: traction(u, d) * u**-k, a, left=-k, right=edge)
    total -= part(lambda u, d: traction(u, d) * (x + u) ** -k, a, right=edge)
    if x < a:
        total -= part(lambda u, d: traction(u, a - u) * d**-k, x, right=-k)
        total -= part(lambda u, d: traction(x + u, d) * u**-k, a - x, left=-k, right=edge)
    else:
        total -= part(lambda u, d: traction(u, d) * (x - a + d) ** -k, a, right=edge)
    return compliance / k * total


def load_within(x, s, power):
    """∫_0^x (s²-t²)^power dt, 0 for t > s; the traction (44) integrated as it is printed."""
    whole = integrate(lambda u, d: (d * (s + u)) ** power, s, right=power)
    if x >= s:
        return whole
    if x > s / 2:
        return whole - integrate(lambda u, d: (d * (s + x + u)) ** power, s - x, right=power)
    return integrate(lambda u, d: (s**2 - u**2) ** power, x)


def derivative(f, s, scale=1):
    """Central difference, Richardson-extrapolated; f is smooth on the scale of scale s."""
    steps = [scale * s * mp.mpf(2) ** -j for j in range(4, 10)]
    table = [(f(s + h) - f(s - h)) / (2 * h) for h in steps]
    for order in range(1, len(table)):
        factor = mp.mpf(4) ** order
        pairs = zip(table, table[1:], strict=False)
        table = [(factor * fine - coarse) / (factor - 1) for coarse, fine in pairs]
    return table[0]


def abel_derivative(slope, k, s, flat=0):
    """d/ds ∫_flat^s x f'(x) (s²-x²)^(-(1-k)/2) dx of (5), (23); slope = f'."""
    power = (k - 1) / 2

    def inner(s):
        def f(u, d):
            return (flat + u) * slope(flat + u) * (d * (s + flat + u)) ** power

        return integrate(f, s - flat, right=power)

    return derivative(inner, s, (s - flat) / s)


@lru_cache
def parabola(k):
    """abel_derivative of f = x²/2 at s = 1."""
    return abel_derivative(lambda x: x, k, mp.mpf(1))


class Medium:
    """Elastic parameters (3), (4) and the integrals (5)-(8), (10), (11), (35) of one half-plane."""

    def __init__(self, E0, nu, k, y0):
        self.E0, self.nu, self.k, self.y0 = mp.mpf(E0), mp.mpf(nu), nonzero(k), mp.mpf(y0)
        k, nu = self.k, self.nu
        self.beta = mp.sqrt((1 + k) * (1 - k * nu / (1 - nu)))
        self.C = (
            2 ** (1 + k)
            / mp.pi
            * mp.gamma((3 + k + self.beta) / 2)
            * mp.gamma((3 + k - self.beta) / 2)
            / mp.gamma(2 + k)
        )
        sine = mp.sin(self.beta * mp.pi / 2)
        self.b = (1 - nu**2) * self.beta * self.C * sine / (k * (k + 1))
        self.g = (1 - nu**2) * (k + 1) * self.C * sine / (k * self.beta)
        self.alpha = self.g / self.b

    def density(self, derivative, s, parameter=None):
        """n_y(s) by (5), n_x by (23) with parameter = g, from abel_derivative at s."""
        k, parameter = self.k, self.b if parameter is None else parameter
        factor = 2 * self.E0 * mp.cos(k * mp.pi / 2) / (mp.pi * parameter * k * self.y0**k * s**k)
        return factor * derivative

    def load(self, density, a):
        """(6), or (22)."""
        return integrate(lambda u, d: density(u) * u**self.k, a, left=self.k)

    def pressure(self, density, x, a):
        """(7), or (18)."""
        k, power = self.k, (self.k - 1) / 2
        factor = mp.gamma((2 + k) / 2) / (mp.sqrt(mp.pi) * mp.gamma((1 + k) / 2))
        return factor * integrate(lambda u, d: density(x + u) * (u * (2 * x + u)) ** power, a - x, left=power)

    def constant(self):
        k = self.k
        return mp.gamma((2 + k) / 2) * mp.gamma((1 - k) / 2) / mp.sqrt(mp.pi)

    def decaying(self, x, s):
        """(s/x)^k F(k/2, (1+k)/2; (2+k)/2; s²/x²)."""
        k = self.k
        return (s / x) ** k * mp.hyp2f1(k / 2, (1 + k) / 2, (2 + k) / 2, (s / x) ** 2)

    def relative_displacement(self, density, x, a, start=0, parameter=None):
        """(8); with parameter = g and start = c it is (21) and (35) over mu."""
        parameter = self.b if parameter is None else parameter
        top = min(x, a)

        def integrand(u, d):
            with mp.workdps(mp.mp.dps + (35 if abs(self.k) < 1e-3 else 5)):
                return density(start + u) * (self.constant() - self.decaying(x, start + u))

        power = 0 if start else min(self.k, 0)
        return parameter * self.y0**self.k / self.E0 * integrate(integrand, top - start, left=power)

    def displacement(self, density, x, a, parameter=None):
        """(10), and (11) for x = 0; 0 < k < 1."""
        parameter = self.b if parameter is None else parameter
        top = min(x, a)
        result = self.constant() * integrate(lambda u, d: density(top + u), a - top) if a > top else mp.mpf(0)
        if x > 0:
            result += integrate(lambda u, d: density(u) * self.decaying(x, u), top)
        return parameter * self.y0**self.k / self.E0 * result


class Cylinder(Medium):
    """Parabolic cylinder (41) on the medium; n_y is proportional to s, as (5) is homogeneous."""

    def __init__(self, E0, nu, k, y0, R, P):
        super().__init__(E0, nu, k, y0)
        self.R, self.P = mp.mpf(R), mp.mpf(P)
        self.slope = self.density(parabola(self.k) / self.R, mp.mpf(1))
        self.a = (self.P / self.load(self.n, mp.mpf(1))) ** (1 / (2 + self.k))

    def n(self, s):
        """n_y(s)."""
        return self.slope * s

    def stick_half_width(self, z):
        """c from (34), z = 1 - Q/(mu P)."""
        return self.a * mp.mpf(z) ** (1 / (2 + self.k))
