"""Imports point one way: a room knows only the rooms named before it. Private names stay in their file."""

import ast
from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parent.parent
# In the order in which data flows. A folder that is not named here is a room of its own parent.
ROOMS = (
    "forms",
    "analytic",
    "simulations.version",
    "simulations.scene",
    "simulations.fem",
    "simulations.solvers",
    "simulations.loading",
    "simulations.runs",
    "simulations.output",
    "simulations.command",
    "simulations.studies",
    "simulations",
)
LIBRARIES = {  # what a room may import beside the standard library and the rooms before it; None: anything
    "forms": {"numpy", "ufl"},
    "analytic": {"numpy", "scipy"},
    "simulations.scene": {"numpy", "scipy", "sympy", "pydantic", "pydantic_core"},
}
STRANGERS = {("analytic", "forms")}  # rooms that do not know each other, whatever their order
SOLVERS = {"dolfinx", "petsc4py", "mpi4py", "gmsh", "basix", "ufl", "numpy", "scipy", "sympy", "pydantic", "h5py"}
SOLVERS |= {"matplotlib", "meshio", "pandas"}
FILES = sorted(path for room in ("forms", "analytic", "simulations") for path in (ROOT / room).rglob("*.py"))


def module_of(path: Path) -> str:
    """Dotted name of a file; that of its folder for ``__init__.py``."""
    return ".".join(path.relative_to(ROOT).with_suffix("").parts).removesuffix(".__init__")


def room_of(module: str) -> str | None:
    """The innermost room that a module lies in; None outside the project."""
    inside = [room for room in ROOMS if module == room or module.startswith(room + ".")]
    return max(inside, key=len, default=None)


def imports(path: Path):
    """(module, name) of every import in a file, inside functions and type-checking blocks too; name None: whole."""
    package = path.relative_to(ROOT).parent.parts
    for node in ast.walk(ast.parse(path.read_text(encoding="utf-8"))):
        if isinstance(node, ast.Import):
            yield from ((alias.name, None) for alias in node.names)
        elif isinstance(node, ast.ImportFrom):
            base = package[: len(package) - node.level + 1] if node.level else ()
            module = ".".join([*base, *([node.module] if node.module else [])])
            yield from ((module, alias.name) for alias in node.names)


def resolved(module: str, name: str | None) -> str:
    """The module that an import reaches: a submodule where ``name`` is one."""
    path = ROOT.joinpath(*module.split("."), f"{name}.py")
    folder = ROOT.joinpath(*module.split("."), str(name), "__init__.py")
    return f"{module}.{name}" if name and (path.exists() or folder.exists()) else module


@pytest.mark.parametrize("path", FILES, ids=[str(path.relative_to(ROOT)) for path in FILES])
def test_imports_point_one_way(path):
    mine = room_of(module_of(path))
    for module, name in imports(path):
        theirs = room_of(resolved(module, name))
        if theirs is None:
            library = module.partition(".")[0]
            allowed = LIBRARIES.get(mine)
            assert allowed is None or library not in SOLVERS or library in allowed, f"{mine} imports {library}"
            continue
        assert ROOMS.index(theirs) <= ROOMS.index(mine), f"{mine} imports {theirs} ({module})"
        assert (mine, theirs) not in STRANGERS, f"{mine} imports {theirs}"


@pytest.mark.parametrize("path", FILES, ids=[str(path.relative_to(ROOT)) for path in FILES])
def test_private_names_stay_in_their_file(path):
    for module, name in imports(path):
        if room_of(module) and name:
            assert not name.startswith("_") or name == "__version__", f"{name} of {module}"


def test_no_circle():
    """No file imports, by whatever way, a file that imports it."""
    graph = {
        module_of(path): {resolved(m, n) for m, n in imports(path) if room_of(m)} - {module_of(path)} for path in FILES
    }
    graph = {module: {target for target in targets if target in graph} for module, targets in graph.items()}
    packages = {module_of(path) for path in FILES if path.name == "__init__.py"}  # a room's list of what it offers
    done: set[str] = set()

    def visit(module, way):
        assert module not in way, " -> ".join([*way[way.index(module) :], module])
        if module not in done:
            for target in sorted(graph[module] - packages):
                visit(target, [*way, module])
            done.add(module)

    for module in sorted(graph):
        visit(module, [])
