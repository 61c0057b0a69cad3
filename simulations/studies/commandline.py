"""The command line that all studies share: -h, --version, --output, --page, and one line for whatever is wrong."""

from argparse import Namespace
from pathlib import Path

from ..command.arguments import Parser
from ..output.folder import writable
from ..scene import SceneError, shown
from .store import Store


def study_parser(name: str, description: str | None, output: str | None = None, page: str | None = None) -> Parser:
    """Parser of ``python -m simulations.studies.NAME``. output: default folder; page: what its page holds."""
    program = f"python -m simulations.studies.{name}"
    parser = Parser(prog=program, description=description)
    if output is not None:
        parser.add_argument(
            "--output", type=Path, default=Path(output), metavar="DIR", help=f"folder for results (default: {output})"
        )
    if page is not None:
        parser.add_argument("--page", type=Path, metavar="FILE.md", help=f"page with {page}")
    return parser


def refuse_nothing_stored(given: Namespace, name: str):
    """SceneError where --stored asks for what is solved already, and nothing is."""
    if given.stored and not Store(given.output / name).read():
        raise SceneError(f"--stored is not allowed: --output {shown(given.output)} holds nothing that is solved")


def make_folders(given: Namespace):
    """The folders of --output and --page, once everything else is checked; SceneError where one cannot be written."""
    if getattr(given, "output", None) is not None:
        given.output = writable(given.output)
    page = getattr(given, "page", None)
    if page is not None:
        if page.is_dir():
            raise SceneError(f"--page {page} is not allowed: a folder, not a file")
        writable(page.parent, "--page")


def read_map(arguments: list[str], name: str, description: str | None, values: tuple[int, int]) -> Namespace:
    """The checked command line of a map over k and nu. values: how many of each by default; SceneError where wrong."""
    parser = study_parser(name, description, f"results/{name}")
    parser.add_argument("--values", type=int, nargs=2, default=values, metavar=("K", "NU"), help="how many of each")
    given = parser.parse_args(arguments)
    if min(given.values) < 2:
        raise SceneError(f"--values {' '.join(map(str, given.values))} is not allowed: two integers ≥ 2")
    make_folders(given)
    return given
