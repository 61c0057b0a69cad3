"""Scenes from Python: typed tables, numpy's numbers, and that a scene is the same however it was made or sent."""

import pickle
import time

import numpy as np
import pytest
from pydantic import Field, ValidationError
from running import ROOT

from simulations.scene import DEFAULT_SCENE, Scene, SceneError, effects, make_scene, parse
from simulations.scene.fields import Number
from simulations.scene.settings import EffectSwitches, Mesh, Reference, Solver
from simulations.scene.tables import (
    ExponentialCoating,
    Formula,
    Fretting,
    Homogeneous,
    Indentation,
    LinearCoating,
    Parabola,
    Path,
    Power,
    PowerLaw,
    PowerLawCoating,
    Tabulated,
)

SOLID = PowerLaw(E0=210e9, k=0.3, nu="holl", y0_over_a0=10)
LOAD = Fretting(P=1e6, mu=0.3, amplitude=0.9)
FILES = sorted((ROOT / "scenes").glob("*.toml"))


def test_tables_make_the_scene_that_text_makes():
    scene = Scene(title=parse(DEFAULT_SCENE).title, solid=SOLID, indenter=Parabola(R=0.1), load=LOAD)
    assert scene == parse(DEFAULT_SCENE) and hash(scene) == hash(parse(DEFAULT_SCENE))
    assert scene.solid.nu == pytest.approx(1 / 2.3) and scene.solid.y0 == pytest.approx(10 * scene.a0(scene.P))
    assert scene == Scene(
        title=scene.title,
        solid={"E0": 210e9, "k": 0.3, "nu": "holl", "y0_over_a0": 10},
        indenter={"R": 0.1},
        load={"P": 1e6, "mu": 0.3, "amplitude": 0.9},
    )
    named = PowerLaw(E0=210e9, k=0.3, nu="holl", y0=None, y0_over_a0=10)  # a key that does not apply may be named
    assert scene == Scene(title=scene.title, solid=named, indenter=Parabola(R=0.1), load=LOAD)


def test_an_error_of_the_program_is_not_blamed_on_the_title(monkeypatch):
    def check_steepness(*_):
        raise ValueError("a fault of the program")

    monkeypatch.setattr("simulations.scene.scene.check_steepness", check_steepness)
    with pytest.raises(ValidationError, match="a fault of the program"):
        parse(DEFAULT_SCENE)


@pytest.mark.parametrize("path", FILES, ids=[path.stem for path in FILES])
def test_resolved_and_sent_it_is_the_same(path):
    scene = parse(path.read_text())
    assert parse(scene.to_toml()) == scene
    assert make_scene(base=scene) == scene
    assert scene.half_width > 0  # worked out, and not sent
    sent = pickle.loads(pickle.dumps(scene))
    assert sent == scene and "contact" not in vars(sent)
    assert Scene(**{name: getattr(scene, name) for name in Scene.model_fields}) == scene


@pytest.mark.parametrize(
    "scene, kinds",
    [
        ("coating", (PowerLawCoating, Parabola, Fretting)),
        ("linear_coating", (LinearCoating, Parabola, Fretting)),
        ("measured_modulus", (Tabulated, Parabola, Fretting)),
        ("path", (Homogeneous, Parabola, Path)),
        ("indentation", (PowerLaw, Parabola, Indentation)),
        ("quartic", (PowerLaw, Power, Fretting)),
        ("formula", (PowerLaw, Formula, Fretting)),
    ],
)
def test_a_table_is_of_the_kind_that_its_words_say(scene, kinds):
    scene = parse((ROOT / "scenes" / f"{scene}.toml").read_text())
    assert (type(scene.solid), type(scene.indenter), type(scene.load)) == kinds


@pytest.mark.parametrize(
    "key, value, read",
    [
        ("solid.k", np.float64(0.2), 0.2),
        ("solid.k", np.array(0.2), 0.2),
        ("load.P", np.float32(2e6), 2e6),
        ("load.P", np.int64(2), 2.0),
        ("load.cycles", np.int32(3), 3),
        ("load.cycles", 3.0, 3),
        ("effects.coupling", np.False_, False),
    ],
)
def test_numbers_of_numpy_are_numbers(key, value, read):
    table, _, name = key.partition(".")
    found = getattr(getattr(make_scene({key: value}), table), name)
    assert found == read and type(found) is type(read)


def test_a_key_that_is_none_takes_nothing_else_away():
    """A length does, which stands in the place of its ratio to a0."""
    assert make_scene({"solid.y0": None}) == make_scene()
    scene = make_scene({"solid.y0": 0.01})
    assert (scene.solid.y0, scene.solid.y0_over_a0) == (0.01, None)


def test_a_file_may_begin_with_a_byte_order_mark(tmp_path):
    (tmp_path / "scene.toml").write_text("\ufeff" + DEFAULT_SCENE, encoding="utf-8")
    assert make_scene(base=tmp_path / "scene.toml") == make_scene()


def test_the_mean_stress_is_an_unknown_above_0_47():
    assert [make_scene({"solid.nu": nu}).is_mixed for nu in (0.46, 0.47, 0.48)] == [False, False, True]


def test_the_holl_ratio_of_a_homogeneous_solid():
    assert PowerLaw(E0=1, k=0, nu="holl", y0=1).nu == Homogeneous(E0=1, nu="holl").nu == 0.5


def test_fields_are_kept_in_the_order_of_the_files():
    assert make_scene({"output.fields": ["von_mises", "displacement"]}).output.kept == ("displacement", "von_mises")


def test_a_circle_has_all_its_digits_near_its_tip():
    shape = make_scene({"indenter.profile": "circle", "indenter.R": 0.1}).shape
    assert shape.height(1e-8) == pytest.approx(1e-16 / 0.2, rel=1e-12, abs=0)


def test_points_may_be_an_array():
    points = np.array([[1e6, 0.0], [1e6, 2e5]])
    assert Path(points=points, mu=0.3) == Path(points=[(1e6, 0), (1e6, 2e5)], mu=0.3)
    assert Path(points=points, mu=0.3).P == 1e6


@pytest.mark.parametrize(
    "make, words",
    [
        (lambda: PowerLaw(E0=-1, k=0.3, nu=0.3, y0=1), "solid.E0 = -1 is not allowed: a number > 0"),
        (lambda: PowerLaw(E0=np.float64(-1), k=0.3, nu=0.3, y0=1), "solid.E0 = -1.0 is not allowed"),
        (lambda: PowerLaw(E0=1, k=0.3, nu=0.3), "solid.y0 is missing"),
        (lambda: PowerLaw(E0=1, K=0.3), "solid.K = 0.3 is not a key of the scene language: did you mean solid.k"),
        (lambda: Homogeneous(E0=1, k=0.3, nu=0.3), 'beside solid.modulus = "homogeneous"'),
        (lambda: ExponentialCoating(E0=1, E_substrate=1, nu="holl", thickness=1), 'modulus = "exponential"'),
        (lambda: Parabola(R="0.1"), "indenter.R = '0.1' is not allowed"),
        (lambda: Fretting(P=True, mu=0.3, amplitude=0.5), "load.P = True is not allowed"),
        (lambda: Fretting(P=1, mu=0.3, amplitude=0.5, points=[]), "beside load.P"),
        (lambda: Path(points=[(1, 0), (1, 0.5)], mu=0.3), "|Q| < mu P"),
        (lambda: Mesh(degree=4), "mesh.degree = 4 is not allowed: an integer, 1 ≤ value ≤ 3"),
        (lambda: Solver(theta=1, method="condensed"), 'solver.theta = 1 is not allowed with solver.method'),
        (lambda: Reference(kind="truth"), "reference.kind = 'truth' is not allowed"),
        (lambda: EffectSwitches(symmetry="yes"), "effects.symmetry = 'yes' is not allowed: true or false or \"auto\""),
        (lambda: Scene(solid=SOLID, indenter=SOLID, load=LOAD), "indenter = PowerLaw"),
        (lambda: Scene(solid=SOLID, indenter=Parabola(R=0.1)), "load.P is missing"),
        (lambda: Scene(title=3, solid=SOLID, indenter=Parabola(R=0.1), load=LOAD), "title = 3 is not allowed"),
        (lambda: Scene(solid=SOLID, indenter=Parabola(R=0.1), load=LOAD, lod={}), "lod = {} is not a key"),
        (lambda: Scene.model_validate({"solid": {"E0": 1}}), "solid.k is missing"),
        (lambda: make_scene({"load.P": np.array([1e6, 2e6])}), "load.P = array([1000000., 2000000.]) is not allowed"),
    ],
)
def test_refused_in_one_line(make, words):
    with pytest.raises(SceneError) as error:
        make()
    assert words in str(error.value) and str(error.value).isprintable()


def test_nothing_can_be_changed():
    scene = make_scene()
    for table, name in ((scene, "title"), (scene.solid, "k"), (scene.effects, "coupling")):
        with pytest.raises(ValueError, match="frozen"):
            setattr(table, name, 1)


def test_a_scene_is_made_at_once():
    """A few milliseconds: the best of some, for the machine may be busy."""
    seconds = []
    for _ in range(20):
        start = time.perf_counter()
        make_scene({"load.amplitude": 0.5})
        seconds.append(time.perf_counter() - start)
    assert min(seconds) < 0.01


def wear():
    """An effect that is made anew by every call, as by a cell of a notebook."""
    return effects.Effect(
        "wear",
        lambda scene: effects.Verdict(scene.effects.wear > 0, f"effects.wear = {scene.effects.wear:g}", "it wears"),
        keys={"wear": (Number, Field(0.0, ge=0, description="m²/N"))},
    )


def test_an_effect_that_is_added_again_is_there_once():
    before = [*effects.ALL]
    effects.add(wear())
    effects.add(again := wear())
    try:
        with pytest.raises(ValueError, match="not in list"):  # and nothing is removed
            effects.remove(again, effects.Effect("other", again.judge))
        assert effects.ALL == [*before, again]
    finally:
        effects.remove(again)
    assert effects.ALL == before


def test_a_scene_from_before_an_effect_was_added_is_refused():
    """As one from before it was removed: neither says what is to be solved now."""
    before, entry = make_scene(), wear()
    effects.add(entry)
    try:
        with pytest.raises(SceneError, match="^effects.wear: .* added .* after the scene was made"):
            effects.Effects(before)
        again = make_scene(base=before)
        assert again.effects.wear == 0 and "wear" not in effects.Effects(again)
        assert "wear" not in effects.Effects(Scene(solid=before.solid, indenter=before.indenter, load=before.load))
    finally:
        effects.remove(entry)
    with pytest.raises(SceneError, match="^effects.wear: .* removed after the scene was made"):
        effects.Effects(again)
    effects.Effects(before)


def test_an_added_effect_has_its_keys_in_the_scene():
    entry = wear()
    effects.add(entry)
    try:
        scene = parse(DEFAULT_SCENE, ("effects.wear=2",))
        assert scene.effects.wear == 2.0 and parse(scene.to_toml()) == scene == pickle.loads(pickle.dumps(scene))
        assert effects.Effects(scene).without_reference == ["wear"] and not effects.Effects(scene).has_closed_form
        off = make_scene()
        assert off.effects.wear == 0 and effects.Effects(off).has_closed_form
        with pytest.raises(SceneError, match="effects.wear = -1 is not allowed: a number ≥ 0"):
            make_scene({"effects.wear": -1})
    finally:
        effects.remove(entry)
    with pytest.raises(SceneError, match="effects.wear = 2 is not a key"):
        make_scene({"effects.wear": 2})
