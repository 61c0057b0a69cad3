"""Wrong scenes and command lines, and what the one line about each has to say.

Run under mpirun by test_bad_input: ``python tests/scene/refusals.py`` tries all of them in the current folder on every
rank and prints, as JSON, the line of each.
"""

import json
import sys
from pathlib import Path

from simulations import fretting
from simulations.scene import DEFAULT_SCENE, SceneError

SOLID = "[solid]\nE0 = 2e11\nk = 0.3\nnu = 0.3\ny0 = 0.01\n[indenter]\nR = 0.1\n"
TABLE = '[solid]\nmodulus = "tabulated"\npoints = {}\nnu = 0.3\n[indenter]\nR = 0.1\n[load]\nP = 1e6\n'
SCENES: dict[str, str | bytes] = {
    "empty.toml": "",
    "spaces.toml": " \n\n",
    "prose.toml": "this is no scene",
    "binary.toml": b"\x89PNG\r\n\x1a\n\xff\xfe\x00",
    "latin.toml": 'title = "Stöße"'.encode("latin-1"),
    "open.toml": 'title = "no end',
    "twice.toml": DEFAULT_SCENE.replace("k = 0.3", "k = 0.3\nk = 0.4"),
    "comma.toml": DEFAULT_SCENE.replace("k = 0.3", "k = 0,3"),
    "table_twice.toml": DEFAULT_SCENE + "[load]\nP = 1.0\n",
    "both_y0.toml": DEFAULT_SCENE.replace("k = 0.3", "k = 0.3\ny0 = 1.0"),
    "deep.toml": "a = " + "[" * 5000,
    "digits.toml": "load.P = " + "1" * 5000,
    "no_solid.toml": "[indenter]\nR = 0.1\n[load]\nP = 1e6\n",
    "no_load.toml": SOLID,
    "table_rises.toml": TABLE.format("[[0.0, 2e11], [2e-3, 1e11], [1e-3, 3e11]]"),
    "table_jumps.toml": TABLE.format("[[0.0, 2e11], [1e-3, 1e11], [1e-3, 3e11]]"),
    "table_deep.toml": TABLE.format("[[1e-3, 2e11], [2e-3, 1e11]]"),
    "table_short.toml": TABLE.format("[[0.0, 2e11]]"),
    "table_soft.toml": TABLE.format("[[0.0, 2e11], [1e-3, 0.0]]"),
    "points_without_mu.toml": SOLID + "[load]\npoints = [[1e6, 0], [1e6, 1e5]]\n",
    "points_and_P.toml": SOLID + "[load]\nP = 1e6\nmu = 0.3\npoints = [[1e6, 0]]\n",
    "points_slide.toml": SOLID + "[load]\nmu = 0.3\npoints = [[1e6, 0], [1e6, 3e5]]\n",
    "points_nearly_slide.toml": SOLID + "[load]\nmu = 0.3\npoints = [[1e6, 0], [1e6, 299999.9999995]]\n",
    "points_start.toml": SOLID + "[load]\nmu = 0.3\npoints = [[1e6, 1e5]]\n",
    "points_pull.toml": SOLID + "[load]\nmu = 0.3\npoints = [[1e6, 0], [-1e6, 0]]\n",
    "points_triple.toml": SOLID + "[load]\nmu = 0.3\npoints = [[1e6, 0, 0]]\n",
    "points_text.toml": SOLID + '[load]\nmu = 0.3\npoints = [["1e6", 0]]\n',
    "points_empty.toml": SOLID + "[load]\nmu = 0.3\npoints = []\n",
    "date.toml": DEFAULT_SCENE.replace("k = 0.3", "k = 2026-01-01"),
    "key_without_table.toml": "k = 0.3\n" + DEFAULT_SCENE,
    "scene.txt": DEFAULT_SCENE,
    "array_of_tables.toml": "[[solid]]\nk = 0.3\n",
}


def by_set(*pairs):
    return tuple(word for pair in pairs for word in ("--set", pair))


FORMULA = "indenter.profile=formula"
REFUSED: dict[str, tuple[tuple[str, ...], tuple[str, ...]]] = {
    # unknown
    "misspelt key": (by_set("load.amplitud=0.5"), ("load.amplitud", "did you mean load.amplitude?")),
    "wrong case": (by_set("solid.e0=1"), ("did you mean solid.E0?",)),
    "Q_A": (by_set("load.Q_A=2.7e5"), ("load.Q_A = 270000.0", "did you mean load.amplitude = Q_A/(mu P)?")),
    "wrong table": (by_set("solid.mu=0.2"), ("solid.mu", "did you mean load.mu?")),
    "no table": (("key_without_table.toml",), ("k = 0.3", "did you mean solid.k?")),
    "unknown in a table": (by_set("mesh.zzz=1"), ("mesh.zzz", "mesh.facet")),
    "unknown table": (by_set("quark.zzz=1"), ("quark.zzz", "there are title and the tables")),
    "unknown option": (("--ouput", "x"), ("--ouput",)),
    "one dash": (("-output", "x"), ("-output", "did you mean --output?")),
    "one letter": (("-o", "x"), ("option '-o' is not known: did you mean --output?",)),
    "two scenes": (("a.toml", "b.toml"), ("b.toml",)),
    "unknown choice": (by_set("solver.method=fulll"), ("'fulll'", '"condensed" or "full"')),
    "unknown profile": (by_set("indenter.profile=wedge"), ("'wedge'", '"parabola"')),
    "unknown modulus": (by_set("solid.modulus=steel"), ("'steel'", '"power law"')),
    "unknown reference": (by_set("reference.kind=truth"), ("'truth'", '"half-plane"')),
    # types
    "not a number": (by_set("load.mu=high"), ("load.mu = 'high'", "a number")),
    "number as text": (by_set('load.P="1e6"'), ("load.P = '1e6'", "a number")),
    "truth for a number": (by_set("load.P=true"), ("load.P = True", "a number")),
    "list for a number": (by_set("solid.k=[0.3]"), ("solid.k = [0.3]", "a number")),
    "table for a number": (by_set("solid.k={a=1}"), ("solid.k", "a number")),
    "number for truth": (by_set("effects.coupling=0"), ("effects.coupling = 0", "true or false")),
    "text for truth": (by_set("effects.coupling=no"), ("effects.coupling = 'no'", "true or false")),
    "half a cycle": (by_set("load.cycles=1.5"), ("load.cycles = 1.5", "an integer")),
    "number for a text": (by_set("title=3"), ("title = 3", "a text")),
    "two lines for a title": (by_set('title="a\\nb"'), ("title", "one line")),
    "date": (("date.toml",), ("solid.k", "a number")),
    "wrong word": (by_set("solid.nu=hall"), ("solid.nu = 'hall'", '"holl"')),
    # ranges
    "k": (by_set("solid.k=1.2"), ("solid.k = 1.2", "-1 < value < 1")),
    "k = -1": (by_set("solid.k=-1"), ("solid.k = -1", "-1 < value < 1")),
    "nu": (by_set("solid.nu=0.6"), ("solid.nu = 0.6", "-1 < value ≤ 0.5")),
    "E0": (by_set("solid.E0=0"), ("solid.E0 = 0", "a number > 0")),
    "negative P": (by_set("load.P=-1e6"), ("load.P = -1000000.0", "a number > 0")),
    "amplitude": (by_set("load.amplitude=1.0"), ("load.amplitude = 1.0", "1e-06 ≤ value < 1")),
    "amplitude as good as 1": (
        by_set("load.amplitude=0.999999999997"),
        ("Q is 0.999999999997 mu P at most, too close to sliding", "0.999999999 mu P or less", "load.amplitude"),
    ),
    "Q below the tolerance": (
        by_set("load.mu=1e-6", "load.amplitude=0.05"),
        ("Q is 5e-08 P at most", "tolerance of loads, 1e-09 P", "4e-07 P or more (load.amplitude)"),
    ),
    "no amplitude at all": (by_set("load.amplitude=0"), ("load.amplitude = 0", "1e-06 ≤ value < 1")),
    "cycles": (by_set("load.cycles=-1"), ("load.cycles = -1", "0 ≤ value ≤ 1000")),
    "facet": (by_set("mesh.facet=0"), ("mesh.facet = 0", "0.001 ≤ value ≤ 0.5")),
    "extent": (by_set("mesh.extent=1"), ("mesh.extent = 1", "4 ≤ value ≤ 10000")),
    "increments": (by_set("solver.increments=0"), ("solver.increments = 0", "1 ≤ value ≤ 1000")),
    "theta out of range": (by_set("solver.theta=2"), ("solver.theta = 2", "-1 ≤ value ≤ 1")),
    "elastic slip": (by_set("effects.elastic_slip=-1"), ("effects.elastic_slip = -1", "a number > 0")),
    # no numbers
    "nan": (by_set("indenter.R=nan"), ("indenter.R = nan", "a number")),
    "infinity": (by_set("indenter.R=inf"), ("indenter.R = inf", "a number")),
    "1e400": (by_set("load.P=1e400"), ("load.P = inf", "a number")),
    "1e-400": (by_set("load.P=1e-400"), ("load.P = 0.0", "a number > 0")),
    "huge integer": (by_set("load.P=1" + "0" * 400), ("load.P", "a number")),
    "endless integer": (("digits.toml",), ("not TOML", "digits")),
    # missing
    "no key at all": (("empty.toml",), ("solid.E0 is missing",)),
    "blank": (("spaces.toml",), ("solid.E0 is missing",)),
    "no solid": (("no_solid.toml",), ("solid.E0 is missing",)),
    "no load": (("no_load.toml",), ("load.P is missing",)),
    "no flat": (by_set('indenter.profile="rounded flat"'), ("indenter.flat is missing",)),
    "no formula": (by_set(FORMULA), ("indenter.formula is missing",)),
    "no thickness": (by_set('solid.modulus="power-law coating"'), ("solid.thickness is missing",)),
    "--set without value": (by_set("load.mu"), ("KEY=VALUE",)),
    "--set without key": (by_set("=3"), ("--set '=3' is not allowed: KEY=VALUE",)),
    "--set without anything": (("--set",), ("--set",)),
    "--output without folder": (("--output",), ("--output",)),
    # contradictions
    "theta": (by_set("solver.theta=1", "solver.method=condensed"), ("solver.theta = 1", "0, or", "full")),
    "theta uncoupled": (by_set("solver.theta=1", "effects.coupling=false"), ("solver.theta = 1", "= false: 0, as")),
    "theta -1 uncoupled": (by_set("solver.theta=-1", "effects.coupling=false"), ("solver.theta = -1", "false: 0, as")),
    "no Holl ratio": (by_set("solid.k=-0.3"), ('"holl"', "k = -0.3")),
    "Holl ratio of a coating": (
        by_set('solid.modulus="power-law coating"', "solid.thickness=1e-3"),
        ('"holl"', 'modulus = "power-law coating", k = 0.3'),
    ),
    "friction off, but mu": (by_set("effects.friction=false"), ("load.mu", "beside effects.friction = false")),
    "symmetry with friction": (by_set("effects.symmetry=true"), ("effects.symmetry", "the tangential load breaks it")),
    "locked in without coupling": (
        by_set("effects.friction_in_normal_stage=true", "effects.coupling=false"),
        ("effects.friction_in_normal_stage", "effects.coupling = true"),
    ),
    "incompressible but plain": (
        by_set("solid.nu=0.5", "effects.incompressibility=false"),
        ("effects.incompressibility", "nu = 1/2"),
    ),
    "mixed of degree 1": (by_set("solid.nu=0.5", "mesh.degree=1"), ("mesh.degree = 1", "mixed unknowns: 2 or 3")),
    "mixed at nu < 0": (
        by_set("solid.nu=-0.2", "effects.incompressibility=true"),
        ("effects.incompressibility", "nu = -0.2"),
    ),
    "mixed at nu = 0": (
        by_set("solid.nu=0", "effects.incompressibility=true"),
        ("effects.incompressibility", "nu = 0: lambda is not positive"),
    ),
    "exponent of a parabola": (by_set("indenter.exponent=4"), ("indenter.exponent", 'indenter.profile = "parabola"')),
    "k of a homogeneous solid": (by_set("solid.modulus=homogeneous"), ("solid.k", 'solid.modulus = "homogeneous"')),
    "y0 twice": (
        ("both_y0.toml",),
        ("solid.y0 = 1 and solid.y0_over_a0 = 10 are not allowed together: one of them is to be given",),
    ),
    "table that rises": (("table_rises.toml",), ("solid.points", "depths grow from 0 on")),
    "table that jumps": (("table_jumps.toml",), ("solid.points", "depths grow from 0 on")),
    "table from a depth on": (("table_deep.toml",), ("solid.points", "depths grow from 0 on")),
    "table of one point": (("table_short.toml",), ("solid.points", "two or more pairs [y, E]")),
    "table without stiffness": (("table_soft.toml",), ("solid.points", "E > 0")),
    "points and P": (("points_and_P.toml",), ("load.P", "beside load.points")),
    "bulk strain without friction": (
        by_set("load.bulk_strain=1e-4", "effects.friction=false"),
        ("load.mu", "effects.friction = false"),
    ),
    "bulk strain twice": (
        by_set("load.bulk_strain=1e-4", "load.bulk_stress=1e6"),
        ("load.bulk_strain = 0.0001 and load.bulk_stress = 1e+06 are not allowed together",),
    ),
    "too much bulk strain": (by_set("load.bulk_strain=0.2"), ("load.bulk_strain = 0.2", "-0.1 ≤ value ≤ 0.1")),
    "bulk stress at no depth": (by_set("load.bulk_stress=1e6"), ("load.bulk_depth is missing",)),
    "phase of nothing": (by_set("load.bulk_phase=90"), ("load.bulk_phase = 90", "without load.bulk_strain")),
    "phase of no kind": (by_set("load.bulk_strain=1e-4", "load.bulk_phase=later"), ("'later'", 'or "constant"')),
    "depth of nothing": (by_set("load.bulk_depth=1.0"), ("load.bulk_depth = 1", "without load.bulk_stress")),
    "phase without a cycle": (
        by_set("load.bulk_strain=1e-4", "load.bulk_phase=90", "load.cycles=0"),
        ("load.bulk_phase = 90", "load.cycles = 0"),
    ),
    # numbers that do not fit together
    "overflow": (by_set("load.P=1e300", "solid.E0=1e-300"), ("do not fit together",)),
    "underflow": (by_set("load.P=1e-300", "solid.E0=1e300"), ("do not fit together",)),
    "no pressure": (
        by_set("load.P=1e-300", "solid.E0=1e-307", "indenter.R=1e41"),
        ("do not fit together: a0 = 1.01615e+24 m, P/a = 0 Pa",),
    ),
    "load beyond the circle": (
        by_set("indenter.profile=circle", "load.P=1e13"),
        ("do not fit together", "load.P = 1e+13 N/m, indenter.R = 0.1 m", "before it carries P"),
    ),
    "load beyond the parabola": (
        by_set("load.P=1e13"),
        ("on indenter.R = 0.1 m", "less than 1 is allowed", "load.P = 1e+13 N/m"),
    ),
    "modulus in GPa": (
        by_set("solid.E0=210"),
        ("a = 33 m on indenter.R = 0.1 m", "look at solid.E0 = 210 Pa, solid.k = 0.3, solid.y0 = 222 m, load.P = "),
    ),
    "radius of no size": (
        by_set("indenter.R=1e-7", "indenter.profile=power", "indenter.exponent=4"),
        ("on indenter.R = 1e-07 m", "less than 1 is allowed"),
    ),
    "formula of another size": (
        by_set(FORMULA, "indenter.formula=x**2/2e-9"),
        ("indenter.formula = 'x**2/2e-9'", "less than 1 is allowed"),
    ),
    # points
    "points without mu": (("points_without_mu.toml",), ("load.mu is missing",)),
    "points that slide": (("points_slide.toml",), ("load.points", "|Q| < mu P")),
    "points that nearly slide": (("points_nearly_slide.toml",), ("too close to sliding", "load.points")),
    "points that start aside": (("points_start.toml",), ("load.points", "the first point has Q = 0")),
    "points that pull": (("points_pull.toml",), ("load.points", "P > 0")),
    "points of three": (("points_triple.toml",), ("load.points", "pairs [P, Q]")),
    "points of text": (("points_text.toml",), ("load.points", "pairs [P, Q]")),
    "no points": (("points_empty.toml",), ("load.points = []", "pairs [P, Q]")),
    # output
    "unknown field": (
        by_set('output.fields=["stress_zx"]'),
        ("output.fields = ['stress_zx']", "a list of displacement"),
    ),
    "no field": (by_set("output.fields=[]"), ("output.fields = []", "a list of displacement")),
    "states of no kind": (by_set("output.states=some"), ("output.states = 'some'", '"named" or "all"')),
    "unknown state": (
        by_set('output.states=["A", "F"]'),
        ("output.states", "'F'", "this run has normal, A, B, C, D, E"),
    ),
    "state of a cycle": (by_set("load.cycles=0", 'output.states=["E"]'), ("output.states", "this run has normal, A")),
    "line of four": (by_set("output.lines=[[0, 0, 1e-3, 9]]"), ("output.lines", "[x0, y0, x1, y1, n]")),
    "line of one point": (by_set("output.lines=[[0, 0, 0, 1e-3, 1]]"), ("output.lines", "2 ≤ n")),
    "line without length": (by_set("output.lines=[[0, 1e-3, 0, 1e-3, 9]]"), ("output.lines", "two different ends")),
    "line above the surface": (by_set("output.lines=[[0, 0, 0, -1e-3, 9]]"), ("output.lines", "y ≥ 0")),
    "half a point on a line": (by_set("output.lines=[[0, 0, 0, 1e-3, 9.5]]"), ("output.lines", "an integer n")),
    "line that leaves the domain": (
        by_set("output.lines=[[0, 0, 0, 1e-3, 9], [0, 0, 0, 1, 9]]"),
        ("output.lines: [0.0, 0.0, 0.0, 1.0, 9] leaves the domain", "0 ≤ y ≤ 0.02089 m"),
    ),
    "point outside": (by_set("output.points=[[-1, 0]]"), ("output.points: [-1.0, 0.0] leaves the domain",)),
    "points of places": (by_set("output.points=[1, 2]"), ("output.points", "pairs [x, y]")),
    # formulas
    "formula of code": (by_set(FORMULA, "indenter.formula=__import__('os')"), ("indenter.formula", "arithmetic")),
    "half a formula": (by_set(FORMULA, "indenter.formula=x +"), ("indenter.formula", "arithmetic")),
    "long formula": (
        by_set(FORMULA, f"indenter.formula=x**2{'+0*x' * 125}"),
        ("a text in one line of at most 500 characters",),
    ),
    "end within 1.5 a": (
        by_set(FORMULA, "indenter.formula=x**2/0.2+1e-6*(1.3e-3-sqrt(1.69e-6-x**2))"),
        ("no finite value at x = 0.00130003, and one is needed up to x = 0.00157",),
    ),
    "other variable": (by_set(FORMULA, "indenter.formula=y**2"), ("indenter.formula", "arithmetic")),
    "formula without x": (by_set(FORMULA, "indenter.formula=R+1"), ("indenter.formula", "depend on x")),
    "tower of powers": (by_set(FORMULA, "indenter.formula=x*9**9**9"), ("indenter.formula", "no float")),
    "tower of negative powers": (by_set(FORMULA, "indenter.formula=x*9**-9**7"), ("indenter.formula", "no float")),
    "division by zero": (by_set(FORMULA, "indenter.formula=x/0"), ("indenter.formula", "real function")),
    "imaginary": (by_set(FORMULA, "indenter.formula=sqrt(-x)"), ("indenter.formula", "real function")),
    "not convex": (by_set(FORMULA, "indenter.formula=x**2/R-1e7*x**4"), ("not convex",)),
    "formula below 0": (
        by_set(FORMULA, "indenter.formula=-x**2"),
        ('indenter.formula = "-x**2" is not allowed: f is to be 0 at 0, positive beside it, and convex',),
    ),
    "concave formula": (
        by_set(FORMULA, "indenter.formula=x**0.5", "solid.y0=0.01"),
        ('indenter.formula = "x**0.5" is not allowed: f is to be 0 at 0, positive beside it, and convex',),
    ),
    "not convex far out": (
        by_set(FORMULA, "indenter.formula=x**2-x**3*1e6"),
        ('indenter.formula = "x**2-x**3*1e6" is not allowed', "not convex up to x = 1.02e-06"),
    ),
    "does not start at 0": (by_set(FORMULA, "indenter.formula=1+x**2"), ("indenter.formula",)),
    "two arguments": (by_set(FORMULA, "indenter.formula=sqrt(x, x)"), ("indenter.formula", "arithmetic")),
    "kink": (
        by_set(FORMULA, "indenter.formula=x**2/(2*R)+0.02*(x-5e-4+sqrt((x-5e-4)**2))"),
        ("indenter.formula", "a kink"),
    ),
    # files
    "scene for PETSc": (
        ("-fretting_snes_monitor", "scene.txt", "--explain"),
        ("scene scene.txt stands after the PETSc option '-fretting_snes_monitor': put it first",),
    ),
    "absent scene": (("absent.toml",), ("absent.toml", "No such file")),
    "folder for a scene": ((".",), ("cannot be read", "Is a directory")),
    "device for a scene": (("/dev/zero",), ("/dev/zero", "not a text file")),
    "prose": (("prose.toml",), ("not TOML", "line 1")),
    "binary": (("binary.toml",), ("binary.toml", "not text in UTF-8")),
    "other encoding": (("latin.toml",), ("latin.toml", "not text in UTF-8")),
    "open text": (("open.toml",), ("open.toml", "not TOML", "no end")),
    "key twice": (("twice.toml",), ("twice.toml", "not TOML", "overwrite", "line 5,", "'k = 0.4'")),
    "decimal comma": (("comma.toml",), ("scene comma.toml is not TOML", "line 4,", "'k = 0,3'")),
    "table twice": (("table_twice.toml",), ("not TOML",)),
    "deep list": (("deep.toml",), ("not TOML",)),
    "array of tables": (("array_of_tables.toml",), ("solid",)),
    "zero byte in a name": (("a\0.toml",), ("cannot be read",)),
    "output nowhere": (("--output", ""), ("argument --output: '' is not allowed: the name of a file or folder",)),
    "resume nowhere": (("--resume", ""), ("argument --resume: '' is not allowed",)),
    "scene without a name": (("",), ("argument scene: '' is not allowed",)),
    "output below a file": (("--output", "empty.toml/results"), ("--output", "Not a directory")),
    "output is a file": (("--output", "empty.toml"), ("--output", "empty.toml is a file, not a folder")),
    "output in /proc": (("--output", "/proc/results"), ("--output", "cannot be written")),
    "resume nothing": (("--resume", "."), ("not the folder of a run",)),
    "resume absent": (("--resume", "absent"), ("not the folder of a run",)),
    "resume a file": (("--resume", "empty.toml"), ("not the folder of a run",)),
    "resume with keys": (("--resume", ".", *by_set("load.mu=0.2")), ("--resume takes no scene",)),
}


def write_scenes(folder: Path):
    """The files that REFUSED names."""
    for name, content in SCENES.items():
        (folder / name).write_bytes(content if isinstance(content, bytes) else content.encode())


def refusal(arguments) -> str | None:
    """The line about a command line, None where there is none."""
    try:
        fretting.main(list(arguments))
    except SceneError as error:
        return str(error)
    return None


if __name__ == "__main__":
    from simulations.command.command import comm

    sys.stdout = sys.stderr  # whatever is said, it is not an answer
    lines = {}
    for case, (words, _) in REFUSED.items():
        found = comm.gather(refusal(words))
        lines[case] = found
    if comm.rank == 0:
        json.dump(lines, sys.__stdout__)
