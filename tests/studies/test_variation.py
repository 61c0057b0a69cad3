"""What a sweep varies: values of keys, rows of a table, and bad input."""

import pytest
from running import run_command

import simulations.sweep as command
from simulations import SceneError
from simulations.scene import DEFAULT_SCENE
from simulations.studies import sweeping
from simulations.studies.sweeping import Table
from simulations.studies.variation import check, product, read_table, read_vary

BAD = {
    "nothing": ([], "nothing varies"),
    "no key": (["--vary", "=1,2"], "KEY=FIRST:LAST:COUNT"),
    "no value": (["--vary", "solid.k="], "KEY=FIRST:LAST:COUNT"),
    "a hole": (["--vary", "solid.nu=holl,,0.3"], "missing between two commas"),
    "unknown key": (["--vary", "solid.kk=0.1,0.2"], "solid.k?"),
    "twice": (["--vary", "solid.k=0.1,0.2", "--vary", "solid.k=0.3,0.4"], "twice"),
    "same value": (["--vary", "solid.k=0.1,0.1"], "twice"),
    "set and vary": (["--vary", "solid.k=0.1,0.2", "--set", "solid.k=0.3"], "--set solid.k=0.3"),
    "two keys for one": (["--vary", "solid.y0=1,2", "--vary", "solid.y0_over_a0=1,2"], "y0"),
    "set for another": (["--vary", "solid.y0_over_a0=1,2", "--set", "solid.y0=1"], "a key of --set solid.y0=1"),
    "one end": (["--vary", "solid.k=0.1:0.1:3"], "two different ends"),
    "no end": (["--vary", "solid.k=0.1:1e999:3"], "two different ends"),
    "a long count": (["--vary", f"solid.k=0.1:0.2:{'9' * 5000}"], "COUNT from 2 to 100000"),
    "one value": (["--vary", "solid.k=0.1:0.2:1"], "2 to 100000"),
    "no count": (["--vary", "solid.k=0.1:0.2"], "FIRST:LAST:COUNT"),
    "words": (["--vary", "solid.k=a:b:3"], "FIRST:LAST:COUNT"),
    "out of range": (["--vary", "solid.k=0.1,1.5"], "1.5"),
    "no number": (["--vary", "load.mu=0.1,nan"], "load.mu = nan is not allowed"),
    "too many": (["--vary", "solid.k=0:0.9:1000", "--vary", "load.mu=0.1:0.9:1000"], "1000000 scenes"),
    "part of a count": (["--vary", "solid.k=0.1:0.2:1.5"], "COUNT from 2 to 100000"),
    "no file": (["--csv-in", "absent.csv"], "absent.csv cannot be read: No such file"),
    "no scene": (["absent.toml", "--vary", "solid.k=0.1,0.2"], "absent.toml"),
    "option": (["--vry", "solid.k=0.1,0.2"], "--vry"),
}


@pytest.mark.parametrize("words, said", BAD.values(), ids=BAD.keys())
def test_bad_input_is_one_line(tmp_path, monkeypatch, words, said):
    monkeypatch.chdir(tmp_path)
    with pytest.raises(SceneError) as refusal:
        command.read([*words, "--output", "out"])
    assert said in str(refusal.value) and "\n" not in str(refusal.value)
    assert list(tmp_path.iterdir()) == []


SHORT, HOLE = "solid.k,load.mu\n0.1\n", "solid.k\n0.1\n \n"
GAP, OWN = "solid.k,load.mu\n0.1,0.3\n0.2, \n", "load.mu,status,reason,a[m]\n0.3,done,,0.001\n"
TABLES = {"": "keys", "solid.k\n": "keys", "solid.k\n\n": "keys", "solid.k,solid.k\n1,2\n": "keys"}
TABLES |= {"solid.kk\n0.1\n": "solid.k?"}
TABLES |= {"solid.k;load.mu\n0,1;0,2\n": "separated by ;", "solid.k\tload.mu\n0.1\t0.2\n": "separated by tabs"}
TABLES |= {"solid.k,load.mux\n0.1,0.3\n": "load.mux = 0.3 is not a key"}
TABLES |= {"load.P,load.mu\n1e6,200\n1e7,300\n": "load.mu = 200 is not allowed"}
TABLES |= {f'title,solid.k\n"{"a" * 140_000},0.1\n': "is not a table: field larger"}
TABLES |= {GAP: "in.csv, line 3: load.mu is empty", OWN: "its column status is what a sweep found, not a key"}
TABLES |= {SHORT: "line 2", HOLE: "line 3", "solid.k\n0.1\n0.1\n": "twice"}


@pytest.mark.parametrize("text, said", TABLES.items(), ids=range(len(TABLES)))
def test_a_bad_table_is_one_line(tmp_path, monkeypatch, text, said):
    monkeypatch.chdir(tmp_path)
    (tmp_path / "in.csv").write_text(text)
    with pytest.raises(SceneError) as refusal:
        command.read(["--csv-in", "in.csv", "--output", "out"])
    assert said in str(refusal.value) and "\n" not in str(refusal.value)
    assert [path.name for path in tmp_path.iterdir()] == ["in.csv"]


def test_a_table_that_a_sweep_wrote_is_read_again(tmp_path):
    rows = [{"effects.coupling": True, "output.states": ["normal", "A"], "title": "a, b", "solid.k": 0.3}]
    Table(rows).to_csv(tmp_path / "keys.csv")
    assert read_table(tmp_path / "keys.csv") == rows


def test_a_blank_after_a_comma_does_not_end_the_quotes(tmp_path):
    (tmp_path / "in.csv").write_text('solid.k, title, load.mu\n0.1, "a, b", "0.2"\n')
    assert read_table(tmp_path / "in.csv") == [{"solid.k": 0.1, "title": "a, b", "load.mu": 0.2}]


def test_a_scene_that_is_not_toml_is_named(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    (tmp_path / "comma.toml").write_text("k = 0,3")
    with pytest.raises(SceneError, match="scene comma.toml is not TOML: .*'k = 0,3'"):
        command.read(["comma.toml", "--vary", "solid.k=0.1,0.2", "--output", "out"])
    assert [path.name for path in tmp_path.iterdir()] == ["comma.toml"]


def test_a_refusal_as_the_user_sees_it(tmp_path):
    words = ["--vary", "solid.kk=0.1,0.2", "--output", "out"]
    done = run_command(*words, module="simulations.sweep", cwd=tmp_path, timeout=120, ranks=2)
    assert done.returncode == 2, done.stderr
    assert sum("did you mean solid.k?" in line for line in done.stderr.splitlines()) == 1
    assert "Traceback" not in done.stderr and done.stdout == "" and list(tmp_path.iterdir()) == []


def test_one_key_for_another_is_found_in_any_row():
    with pytest.raises(SceneError, match="^solid.y0, solid.y0_over_a0 are to vary, but one of them takes the place"):
        check(DEFAULT_SCENE, (), product([{"solid.k": 0.1}, {"solid.y0": 1.0, "solid.y0_over_a0": 2.0}]))


def test_a_key_that_is_set_does_not_vary_from_python_either(monkeypatch):
    monkeypatch.setattr(sweeping, "run_scene", None)
    with pytest.raises(SceneError, match="^solid.k is to vary, and --set solid.k=0.2 gives it one value"):
        sweeping.sweep(vary={"solid.k": [0.1]}, sets=["solid.k=0.2"])


def test_a_refusal_says_the_value_once():
    with pytest.raises(SceneError, match="^solid.kk = 0.1 is not a key"):
        command.read(["--vary", "solid.kk=0.1,0.2", "--output", "out"])


def test_what_is_wrong_without_the_key_that_varies_is_not_blamed_on_it():
    for words, said in ((["--set", "foo=1"], "foo = 1 is not a key"), (["--set", "load.mu=-1"], "load.mu = -1")):
        with pytest.raises(SceneError, match=f"^{said}"):
            command.read([*words, "--vary", "solid.k=0.1,0.2", "--output", "out"])
    with pytest.raises(SceneError, match="^solid.k = 1.5 is not allowed"):
        command.read(["--vary", "solid.k=1.5,2.5", "--output", "out"])


def test_values_of_a_key():
    assert read_vary(["solid.k=-0.5:0.9:15"])["solid.k"][8] == 0.3
    assert read_vary(["a=holl, 0.3"]) == {"a": ["holl", 0.3]}
    assert read_vary(['a="a,b",c']) == {"a": ["a,b", "c"]}
    assert read_vary(['a=["normal","A"],named']) == {"a": [["normal", "A"], "named"]}
    assert read_vary(["a=Bob's, 'x, ]', Ann's"]) == {"a": ["Bob's", "x, ]", "Ann's"]}
    assert read_vary(["a=0.1]\nb = [0.2"]) == {"a": ["0.1]\nb = [0.2"]}
    assert read_vary(["a=true,false"]) == {"a": [True, False]}
    assert read_vary(["a=.1,1.,5.E-3,-.2,0.5.1"]) == {"a": [0.1, 1.0, 0.005, -0.2, "0.5.1"]}
    assert read_vary(["a=[[1, 0], [2, 0.5]]"]) == {"a": [[[1, 0], [2, 0.5]]]}
    pairs = [(1, 3), (1, 4), (2, 3), (2, 4)]
    assert product({"a": [1, 2], "b": [3, 4]}) == [{"a": a, "b": b} for a, b in pairs]
    assert product([{"a": 1}, {"a": 2}]) == [{"a": 1}, {"a": 2}]
    for wrong in ({}, {"a": []}, [], {"a": [1, 1.0]}, {"a": [[1, 0], [1, 0]]}):
        with pytest.raises(SceneError, match="vary|varies") as error:
            product(wrong)
        assert "--vary" not in str(error.value)  # Python has no options
