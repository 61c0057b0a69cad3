"""Whatever is written into a scene: it is a scene, or one line says why not. Never a traceback, never a hang."""

import math

import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from simulations.scene import DEFAULT_SCENE, Scene, SceneError, language, parse
from simulations.scene.text import written

QUICK = settings(max_examples=150, deadline=5000, suppress_health_check=list(HealthCheck))
KEYS = sorted(language())
KINDS = ["power law", "homogeneous", "power-law coating", "linear", "exponential", "tabulated", "parabola", "circle"]
WORDS = ["holl", "auto", *KINDS]
WORDS += ["power", "rounded flat", "formula", "x**2", "x**4/R**3", "cosh(x/R) - 1", "x +", "full", "none", "half-plane"]
numbers = st.one_of(
    st.floats(),
    st.sampled_from([0, 1, -1, 0.5, -0.5, 0.3, 2, 10, 1e-9, 1e-3, 1e3, 1e6, 1e11, 1e300, 1e-300, 10**400, math.nan]),
    st.integers(),
)
values = st.one_of(
    numbers,
    st.booleans(),
    st.sampled_from(WORDS),
    st.text(max_size=20),
    st.lists(st.lists(numbers, max_size=3), max_size=4),
    st.dictionaries(st.text(max_size=3), numbers, max_size=2),
)


def toml(value) -> str:
    """A value as TOML; a dictionary as a table in one line."""
    if isinstance(value, dict):
        return "{" + ", ".join(f"{written(key)} = {written(inner)}" for key, inner in value.items()) + "}"
    return written(value)


def is_a_scene_or_one_line(text, overrides=()):
    try:
        scene = parse(text, overrides)
    except SceneError as error:
        message = str(error)
        assert message and message.isprintable() and len(message) < 1000, message
        return
    assert isinstance(scene, Scene)
    assert parse(scene.to_toml()) == scene, "the resolved scene is another one"


@QUICK
@given(st.dictionaries(st.sampled_from(KEYS), values, max_size=4))
def test_any_value_for_any_key_of_a_good_scene(changes):
    is_a_scene_or_one_line(DEFAULT_SCENE, tuple(f"{key}={toml(value)}" for key, value in changes.items()))


@QUICK
@given(st.dictionaries(st.sampled_from(KEYS), values))
def test_any_choice_of_keys(entries):
    is_a_scene_or_one_line("\n".join(f"{key} = {toml(value)}" for key, value in entries.items()))


NUMBERS = ["solid.k", "solid.nu", "solid.E0", "load.P", "indenter.R"]


@QUICK
@given(st.dictionaries(st.sampled_from(NUMBERS), numbers, min_size=2))
def test_any_numbers(changes):
    is_a_scene_or_one_line(DEFAULT_SCENE, tuple(f"{key}={toml(value)}" for key, value in changes.items()))


@QUICK
@given(st.text(), st.lists(st.text(max_size=30), max_size=2))
def test_any_text(text, overrides):
    is_a_scene_or_one_line(text, tuple(overrides))


@QUICK
@given(st.integers(0, len(DEFAULT_SCENE)), st.integers(0, 20), st.text(max_size=5))
def test_a_good_scene_with_a_piece_replaced(start, length, piece):
    is_a_scene_or_one_line(DEFAULT_SCENE[:start] + piece + DEFAULT_SCENE[start + length :])


@QUICK
@given(st.text("x0123456789.e+-*/^() RpicosnhtaqrlgXy", max_size=30))
def test_any_formula(formula):
    is_a_scene_or_one_line(DEFAULT_SCENE, ("indenter.profile=formula", f"indenter.formula='{formula}'"))


@pytest.mark.parametrize(
    "formula",
    ["9**9**9*x", "x**9**9**9", "9**(1-9**9)*x", "(((" * 200 + "x", "x**2 + " * 300 + "x", "sin(1/x)"],
)
def test_formulas_that_would_take_for_ever(formula):
    with pytest.raises(SceneError, match="is not allowed"):
        parse(DEFAULT_SCENE, ("indenter.profile=formula", f"indenter.formula='{formula}'"))
