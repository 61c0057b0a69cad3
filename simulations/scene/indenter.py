"""The rigid indenter's profile f(x): even and convex, flat for |x| < flat, from the scene's words or a formula.

A formula is read by sympy, so that one text gives the contact terms their f and the closed forms their f' and f".
"""

import ast
import operator
from collections.abc import Callable
from dataclasses import dataclass
from functools import cached_property, lru_cache
from math import isclose, isfinite

import numpy as np
import sympy

from analytic import PowerProfile, Profile

from .errors import SceneError, one_line, shown
from .tables import AnyIndenter, Circle, Formula, Parabola, Power

DISTANCE = sympy.Symbol("x", nonnegative=True)  # |x| - flat >= 0
FUNCTIONS = ("sqrt", "exp", "log", "sin", "cos", "tan", "sinh", "cosh", "tanh")
NAMES = ("x", "R", "pi")
SAME_ORDER = 1e-9  # relative: the digits of R are in the order that sympy finds
OPERATIONS: dict[type, Callable] = {
    ast.Add: operator.add,
    ast.Sub: operator.sub,
    ast.Mult: operator.mul,
    ast.Div: operator.truediv,
    ast.Pow: operator.pow,
    ast.BitXor: operator.pow,  # as sympy reads ^
    ast.USub: operator.neg,
    ast.UAdd: operator.pos,
}


@dataclass(frozen=True)
class Shape:
    """f(x) = formula(|x| - flat), zero for |x| <= flat. formula: sympy expression of DISTANCE; any unit of length."""

    formula: sympy.Expr
    flat: float = 0.0
    known_order: float | None = None  # of a scaled shape: round-off in its formula may hide it

    def scaled(self, length: float, displacement: float) -> "Shape":
        """The same indenter with x in units of ``length`` and f in units of ``displacement``."""
        formula = self.formula.subs(DISTANCE, length * DISTANCE) / displacement
        return Shape(formula, self.flat / length, self.order)

    def height(self, x):
        """f at positions x, numpy."""
        distance = np.maximum(np.abs(np.asarray(x, dtype=float)) - self.flat, 0.0)
        return self._numpy(self.formula)(distance)

    def slope(self, x):
        """f' at positions x >= 0, numpy."""
        distance = np.maximum(np.asarray(x, dtype=float) - self.flat, 0.0)
        return self._numpy(sympy.diff(self.formula, DISTANCE))(distance)

    def analytic(self) -> Profile | PowerProfile:
        """f for the closed forms, with its slope, curvature and the power with which it begins."""
        if self._power:
            return PowerProfile(*self._power)
        slope = sympy.diff(self.formula, DISTANCE)
        derivatives = self.formula, slope, sympy.diff(slope, DISTANCE)
        f, df, ddf = map(self._numpy, derivatives)
        return Profile(f, df, ddf, flat=self.flat, order=self.order)

    @cached_property
    def order(self) -> float:
        """Exponent m of f ~ x^m at the tip (beside the flat)."""
        if self.known_order is not None:
            return self.known_order
        order = float(sympy.limit(DISTANCE * sympy.diff(self.formula, DISTANCE) / self.formula, DISTANCE, 0, "+"))
        return float(round(order)) if isclose(order, round(order), rel_tol=SAME_ORDER) else order

    def defect(self, length: float) -> str | None:
        """Why this is no indenter for contacts of half-width ``length``, or None."""
        x = self.flat + np.linspace(0.0, length, 401)
        with np.errstate(all="ignore"):
            f = self.height(x)
        if not np.all(np.isfinite(f)):
            at = x[~np.isfinite(f)][0]
            return f"it has no finite value at x = {at:g}, and one is needed up to x = {x[-1]:.3g}"
        size = np.ptp(f)
        if f[0] != 0:
            return f"f(0) = {f[0]:g} is not 0"
        bend = np.diff(f, 2)
        if f[1] < 0 or size == 0 or np.any(bend < -1e-12 * size):
            at = x[1 + np.argmin(bend)]
            return f"it is not convex and growing (see x = {at:.3g})" if size else "it is flat"
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
    @lru_cache(maxsize=64)  # to make a function takes longer than many calls of it
    def _numpy(expression):
        function = sympy.lambdify(DISTANCE, expression, modules="numpy")
        return lambda x: function(np.asarray(x, dtype=float)) + np.zeros(np.shape(x))


@lru_cache(maxsize=16)
def shape_of(indenter: AnyIndenter) -> Shape:
    """The profile of a scene's indenter, metres; SceneError where its formula cannot be read."""
    x = DISTANCE
    if isinstance(indenter, Formula):
        return Shape(read_formula("indenter.formula", indenter.formula, indenter.R))
    R = indenter.R
    if isinstance(indenter, Circle):
        return Shape(x**2 / (R + sympy.sqrt(R**2 - x**2)))  # no cancellation for small x
    if isinstance(indenter, Power):
        m = indenter.exponent
        return Shape(R * (x / R) ** (int(m) if m == int(m) else m) / m)
    return Shape(x**2 / (2 * R), flat=0.0 if isinstance(indenter, Parabola) else indenter.flat)


def named(indenter: AnyIndenter) -> str:
    """The key of an indenter's shape with its value."""
    is_formula = isinstance(indenter, Formula)
    key, word = ("formula", one_line(indenter.formula)) if is_formula else ("profile", indenter.profile)
    return f'indenter.{key} = "{word}"'


def read_formula(key: str, text: str, R: float | None) -> sympy.Expr:
    """A formula of x (and R) as a sympy expression; nothing but arithmetic is evaluated."""
    names = NAMES if R else tuple(name for name in NAMES if name != "R")
    allowed = f"arithmetic with {', '.join(names)} and {', '.join(FUNCTIONS)}"
    try:
        tree = ast.parse(text.strip(), mode="eval")
        if not all(_is_arithmetic(node, names) for node in ast.walk(tree)):
            raise SceneError(f"{key} = {shown(text)} is not allowed: {allowed}")
        _constant(tree.body)
        formula = sympy.sympify(text.strip(), locals={"x": DISTANCE, "R": R})
        if not isinstance(formula, sympy.Expr) or not formula.has(DISTANCE):
            raise SceneError(f"{key} = {shown(text)} is not allowed: it has to depend on x")
        if formula.has(sympy.zoo, sympy.nan, sympy.oo, sympy.I) or not isfinite(Shape(formula).order):
            raise SceneError(f"{key} = {shown(text)} is not allowed: it is not a real function that begins like x^m")
        if formula.has(sympy.Abs, sympy.sign):
            raise SceneError(f"{key} = {shown(text)} is not allowed: it has a kink, and f is smooth for x > 0")
        return formula
    except SceneError:
        raise
    except ArithmeticError:
        raise SceneError(f"{key} = {shown(text)} is not allowed: it has numbers that no float holds") from None
    except (SyntaxError, TypeError, ValueError, AttributeError, RecursionError, MemoryError, NotImplementedError):
        raise SceneError(f"{key} = {shown(text)} is not allowed: {allowed}") from None


def _is_arithmetic(node, names):
    if isinstance(node, ast.Constant):
        return type(node.value) in (int, float)
    if isinstance(node, ast.Call):
        return isinstance(node.func, ast.Name) and node.func.id in FUNCTIONS and len(node.args) == 1
    if isinstance(node, ast.Name):
        return node.id in (*names, *FUNCTIONS)
    return isinstance(node, (ast.Expression, ast.BinOp, ast.UnaryOp, ast.Load, *OPERATIONS))


def _constant(node) -> float | None:
    """Value of a part without names; OverflowError or ZeroDivisionError before sympy computes it with all digits."""
    if isinstance(node, ast.Constant):
        return float(node.value)  # type: ignore[arg-type]  # a number: _is_arithmetic
    if isinstance(node, ast.UnaryOp):
        value = _constant(node.operand)
        return None if value is None else OPERATIONS[type(node.op)](value)
    if isinstance(node, ast.Call):
        _constant(node.args[0])
    if isinstance(node, ast.BinOp):
        left, right = _constant(node.left), _constant(node.right)
        if left is not None and right is not None:
            operation = OPERATIONS[type(node.op)]
            value = operation(left, right)
            if operation is operator.pow and value == 0 != left:
                raise OverflowError  # a power too small for a float is a fraction of as many digits
            return value if isinstance(value, float) else None
    return None
