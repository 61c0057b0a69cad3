"""What a run says while it goes, and what reaches PETSc."""

import io
import os
import pty
import re
import warnings
from types import SimpleNamespace

import pytest
from petsc4py import PETSc
from running import coarse_arguments, run_command, start_python

from simulations import __version__
from simulations.command import command, progress
from simulations.command.arguments import set_petsc_options
from simulations.runs.reference import expected_seconds
from simulations.scene import SceneError


@pytest.fixture(scope="module")
def plain(tmp_path_factory):
    done = run_command(*coarse_arguments(tmp_path_factory.mktemp("run")), ranks=2)
    assert done.returncode == 0, done.stderr
    return done.stdout


def test_a_line_an_increment_with_the_time_left(plain):
    lines = [line for line in plain.splitlines() if re.match(r" *\d+/11 ", line)]
    assert len(lines) == 11
    assert all(re.search(r", [\d.]+ s left$", line) for line in lines)
    assert "\x1b" not in plain and "\r" not in plain


@pytest.mark.parametrize("seconds, words", [(0.2, "0.2 s"), (99, "99 s"), (150, "2 min"), (5990, "1 h 40 min")])
def test_durations(seconds, words):
    assert progress.duration(seconds) == words


def test_the_time_left_knows_that_the_reference_has_more_load_steps_on_short_paths():
    """From point to point it makes 8 where a run has one to four, and the rough edges as many as the run."""

    def expected(increments, kind="auto", foreign=()):
        scene = SimpleNamespace(
            reference=SimpleNamespace(kind=kind),
            is_loop=False,
            is_path=True,
            solver=SimpleNamespace(increments=increments),
            effects=SimpleNamespace(elastic_slip=None),
        )
        watch = SimpleNamespace(seconds={"edges": 0.1 * increments})
        effects = SimpleNamespace(has_closed_form=False, without_reference=foreign)
        schedule = [SimpleNamespace(angle=0.0)] * 3 * increments
        return expected_seconds(SimpleNamespace(scene=scene, effects=effects, schedule=schedule, watch=watch))

    assert expected(1) == pytest.approx(expected(4)) == pytest.approx(expected(8) / 2)
    assert expected(4, "closed form") == expected(4, foreign=["traction on the flank"]) == 0.0  # there is none to solve


def test_the_time_left_of_a_resumed_run_is_that_of_its_own_load_steps(monkeypatch):
    said, entries, times = [], [None] * 8, iter([0.0, 30.0])
    monkeypatch.setattr(progress, "say", lambda text, end="": said.append(text))
    monkeypatch.setattr(progress, "describe", lambda entry, simulation: "step")
    monkeypatch.setattr(progress.time, "perf_counter", lambda: next(times))
    shown = progress.Progress()
    shown.begin(SimpleNamespace(schedule=[None] * 10, history=SimpleNamespace(entries=entries)))
    entries.append(None)
    shown.step(SimpleNamespace(step=SimpleNamespace(state="")))
    assert said == ["   9/10  step, 31 s left"]


@pytest.mark.parametrize("state, end", [("", "3 iterations, 31 s left"), ("A", "3 iterations, 0.02 s, 31 s left\n")])
def test_the_time_left_is_seen_on_a_terminal_of_80_columns(state, end, monkeypatch):
    """Of a line that is written over the seconds of the load step give way to it; one that stays is whole."""
    said, entries, times = [], [None] * 8, iter([0.0, 30.0])
    words = "reloading Q/(mu P) = -0.750   c/a = 0.9667   3 iterations, 0.02 s"
    monkeypatch.setenv("COLUMNS", "80")
    monkeypatch.setattr(progress, "say", lambda text, end="": said.append(text + end))
    monkeypatch.setattr(progress, "describe", lambda entry, simulation: words)
    monkeypatch.setattr(progress.time, "perf_counter", lambda: next(times))
    shown = progress.Progress()
    shown._live = True
    shown.begin(SimpleNamespace(schedule=[None] * 10, history=SimpleNamespace(entries=entries)))
    entries.append(None)
    shown.step(SimpleNamespace(step=SimpleNamespace(state=state)))
    (line,) = said
    assert line.endswith(end) and (state or len(line.removeprefix("\r\x1b[K")) < 80)


def test_quiet(tmp_path):
    done = run_command(*coarse_arguments(tmp_path), "--quiet")
    assert (done.returncode, done.stdout, done.stderr) == (0, "", "")
    assert (tmp_path / "summary.json").exists()


def test_a_title_that_the_terminal_cannot_show(tmp_path, monkeypatch):
    monkeypatch.setenv("PYTHONIOENCODING", "latin-1")
    done = run_command(*coarse_arguments(tmp_path, title='"μ → 0.3"', load__cycles=0))
    assert done.returncode == 0, done.stderr
    assert "? ? 0.3: " in done.stdout


def test_on_a_terminal_one_line_is_written_over(tmp_path):
    leader, follower = pty.openpty()
    process = start_python("-m", "simulations.fretting", *coarse_arguments(tmp_path), stdout=follower)
    os.close(follower)
    said = b""
    try:
        while piece := os.read(leader, 4096):
            said += piece
    except OSError:  # how a terminal ends
        pass
    os.close(leader)
    assert process.wait(120) == 0
    steps = [line for line in said.decode().split("\x1b[K") if re.match(r" *\d+/11 ", line)]
    assert len(steps) == 11
    stay = [re.match(r" *(\d+)", line)[1] for line in steps if "\n" in line]
    assert stay == ["3", "4", "5", "6", "7", "11"]  # A B C D E A


def test_an_error_begins_below_a_line_that_is_written_over(monkeypatch):
    terminal = io.StringIO()
    terminal.isatty = lambda: True
    monkeypatch.setattr("sys.stdout", terminal)
    command.say("   3/31", end="")
    command.say("not converged", file=terminal)
    command.say("that is all", file=terminal)
    assert terminal.getvalue() == "   3/31\nnot converged\nthat is all\n"


def test_a_log_of_petsc_that_cannot_be_written_is_refused_before_the_run(tmp_path):
    log = f":{tmp_path / 'missing' / 'log'}"
    done = run_command(*coarse_arguments(tmp_path / "run"), "-log_view", log)
    assert done.returncode == 2 and "cannot be written: there is no such folder" in done.stderr
    assert not (tmp_path / "run").exists() and done.stderr.count("\n") == 1


def test_petsc_monitors_and_log(tmp_path):
    """From the command line and from a file; what nothing asks for is named once."""
    (tmp_path / "petscrc").write_text("-log_view\n")
    options = "-fretting_snes_monitor", "-fretting_snes_monitr", "-options_file", tmp_path / "petscrc"
    done = run_command(*coarse_arguments(tmp_path / "run"), *options, ranks=2)
    assert done.returncode == 0
    assert done.stdout.count("SNES Function norm") > 11
    assert done.stdout.count("PETSc Performance Summary") == 1 and "SNESSolve" in done.stdout
    assert (done.stdout + done.stderr).count("Option left: name:-fretting_snes_monitr") == 1


@pytest.mark.parametrize(
    "option, value, why",
    [
        ("-fretting_snes_type", "nonsense", "Unable to find requested SNES type nonsense"),
        ("-fretting_path_max_it", "many", "Input string many has no integer value"),
        ("-fretting_bulk_mat_mumps_icntl_14", "more", "Input string more has no integer value"),
        ("-options_file", "/nowhere", "Unable to open options file /nowhere"),
    ],
)
def test_options_that_petsc_cannot_read_are_wrong_input(option, value, why):
    """They were a traceback in the middle of the run, whose folder was begun."""
    try:
        with pytest.raises(SceneError) as error:
            set_petsc_options((option, value))
    finally:
        PETSc.Options().delValue(option)
    assert str(error.value).startswith(f"PETSc's options '{option} {value}' are not allowed: {why}")
    assert "\n" not in str(error.value)


def test_warnings_come_once(capfd):
    with warnings.catch_warnings():
        warnings.simplefilter("always")
        command._warn_in_one_line()
        for _ in range(3):
            warnings.warn("the mesh is coarse", UserWarning, stacklevel=1)
    assert capfd.readouterr().err == "warning: the mesh is coarse\n"


def test_every_phase_is_announced(plain):
    for phase in ("mesh ... ", "forms (compiled the first time", "reference ... ", "picture ... "):
        assert len(re.findall(rf"^{re.escape(phase)}.*\d s$", plain, re.M)) == 1, phase


def test_each_value_stands_beside_its_own_error(plain):
    """c/a beside the error of c/a, which is not that of c; the reference's name is whole."""
    rows = {line[:28].strip(): line[28:].split() for line in plain.splitlines() if re.match(r"[a-z].*\[", line)}
    assert {"contact half-width a [m]", "peak pressure [Pa]", "stick half-width c/a [-]"} <= set(rows)
    for name in ("contact half-width a [m]", "peak pressure [Pa]", "stick half-width c/a [-]"):
        mine, theirs, error = map(float, rows[name])
        assert mine / theirs - 1 == pytest.approx(error, rel=0.1, abs=1e-7), name
    assert re.search(r"^ +computed +closed form +relative error$", plain, re.M)


def test_version_and_commands():
    assert run_command("--version").stdout == f"graded-fretting {__version__}\n"
    done = run_command(module="simulations")
    assert done.returncode == 0 and "fretting [SCENE.toml]" in done.stdout and "report DIR" in done.stdout
