"""The rigid indenter's profile f(x): even and convex, flat for |x| < flat, from the scene's words or a formula.

A formula is read by sympy, so that one text gives the weak form its f and the closed forms their f' and f".
"""

import ast
from dataclasses import dataclass
from functools import cached_property

import numpy as np
import sympy
import ufl

from analytic import PowerProfile, Profile

from .language import SceneError

DISTANCE = sympy.Symbol("x", nonnegative=True)  # |x| - flat >= 0
FUNCTIONS = ("sqrt", "exp", "log", "sin", "cos", "tan", "sinh", "cosh", "tanh")
NAMES = ("x", "R", "pi")
UFL = {name: getattr(ufl, {"log": "ln"}.get(name, name)) for name in FUNCTIONS}


@dataclass(frozen=True)
class Indenter:
    """f(x) = formula(|x| - flat), zero for |x| <= flat. formula: sympy expression of DISTANCE; any unit of length."""

    formula: sympy.Expr
    flat: float = 0.0

    def scaled(self, length: float, displacement: float) -> "Indenter":
        """The same indenter with x in units of ``length`` and f in units of ``displacement``."""
        return Indenter(self.formula.subs(DISTANCE, length * DISTANCE) / displacement, self.flat / length)

    def height(self, x):
        """f at positions x, numpy."""
        distance = np.maximum(np.abs(np.asarray(x, dtype=float)) - self.flat, 0.0)
        return self._numpy(self.formula)(distance)

    def form(self, x):
        """f at x as a UFL expression."""
        distance = abs(x) if self.flat == 0 else ufl.max_value(abs(x) - self.flat, 0.0)
        return sympy.lambdify(DISTANCE, self.formula, modules=[UFL])(distance)

    def analytic(self) -> Profile | PowerProfile:
        """f for the closed forms, with its slope, curvature and the power with which it begins."""
        if self._power:
            return PowerProfile(*self._power)
        slope = sympy.diff(self.formula, DISTANCE)
        derivatives = self.formula, slope, sympy.diff(slope, DISTANCE)
        return Profile(*map(self._numpy, derivatives), flat=self.flat, order=self.order)

    @cached_property
    def order(self) -> float:
        """Exponent m of f ~ x^m at the tip (beside the flat)."""
        return float(sympy.limit(DISTANCE * sympy.diff(self.formula, DISTANCE) / self.formula, DISTANCE, 0, "+"))

    def defect(self, length: float) -> str | None:
        """Why this is no indenter for contacts of half-width ``length``, or None."""
        x = self.flat + np.linspace(0.0, length, 401)
        with np.errstate(all="ignore"):
            f = self.height(x)
        if not np.all(np.isfinite(f)):
            return f"it has no finite value at x = {x[~np.isfinite(f)][0]:g}, and the contact is about {length:.3g} wide"
        size = np.ptp(f)
        if f[0] != 0:
            return f"f(0) = {f[0]:g} is not 0"
        bend = np.diff(f, 2)
        if f[1] < 0 or size == 0 or np.any(bend < -1e-12 * size):
            at = x[1 + np.argmin(bend)]
            return f"it is not convex (it bends the other way at x = {at:.3g})" if size else "it is flat"
        return None

    @cached_property
    def _power(self):
        """(A, m) where f = A |x|^m, else None."""
        coefficient, rest = self.formula.as_independent(DISTANCE)
        base, exponent = rest.as_base_exp()
        if self.flat == 0 and base == DISTANCE and exponent.is_number:
            return float(coefficient), float(exponent)
        return None

    @staticmethod
    def _numpy(expression):
        function = sympy.lambdify(DISTANCE, expression, modules="numpy")
        return lambda x: function(np.asarray(x, dtype=float)) + np.zeros(np.shape(x))


def from_scene(values) -> Indenter:
    """The indenter of a scene, metres; SceneError where its formula cannot be read."""
    kind, x = values["indenter.profile"], DISTANCE
    R = values.get("indenter.R")
    if kind == "parabola":
        return Indenter(x**2 / (2 * R))
    if kind == "circle":
        return Indenter(R - sympy.sqrt(R**2 - x**2))
    if kind == "power":
        m = values["indenter.exponent"]
        return Indenter(R * (x / R) ** (int(m) if m == int(m) else m) / m)
    if kind == "rounded flat":
        return Indenter(x**2 / (2 * R), flat=values["indenter.flat"])
    return Indenter(read_formula("indenter.formula", values["indenter.formula"], R))


def read_formula(key: str, text: str, R: float | None) -> sympy.Expr:
    """A formula of x (and R) as a sympy expression; nothing but arithmetic is evaluated."""
    names = NAMES if R else tuple(name for name in NAMES if name != "R")
    allowed = f"arithmetic with {', '.join(names)} and {', '.join(FUNCTIONS)}"
    try:
        for node in ast.walk(ast.parse(text, mode="eval")):
            known = isinstance(node, (ast.Expression, ast.BinOp, ast.UnaryOp, ast.operator, ast.unaryop, ast.Load))
            number = isinstance(node, ast.Constant) and isinstance(node.value, (int, float))
            call = isinstance(node, ast.Call) and isinstance(node.func, ast.Name) and node.func.id in FUNCTIONS
            name = isinstance(node, ast.Name) and node.id in (*names, *FUNCTIONS)
            if not (known or number or call or name):
                raise SceneError(f"{key} = {text!r} is not allowed: {allowed}")
        formula = sympy.sympify(text, locals={"x": DISTANCE, "R": R})
        if not isinstance(formula, sympy.Expr) or not formula.has(DISTANCE):
            raise SceneError(f"{key} = {text!r} is not allowed: it has to depend on x")
        return formula
    except (SyntaxError, TypeError, ValueError, sympy.SympifyError) as error:
        if isinstance(error, SceneError):
            raise
        raise SceneError(f"{key} = {text!r} is not allowed: {allowed}") from None
