"""The command line that all studies share: -h, --version, --output, --page, and one line for whatever is wrong."""

from argparse import Namespace
from pathlib import Path

from ..command.arguments import Parser
from ..output.folder import remove_empty, writable
from ..scene import SceneError, shown
from .engine import Item
from .store import Store


def study_parser(name: str, description: str | None, output: str | None = None, page: str | None = None) -> Parser:
    """Parser of ``python -m simulations.studies.NAME``. output: default folder; page: what its page holds."""
    parser = Parser(prog=f"python -m simulations.studies.{name}", description=description)
    if output is not None:
        parser.add_argument(
            "--output", type=Path, default=Path(output), metavar="DIR", help=f"folder for results (default: {output})"
        )
    if page is not None:
        parser.add_argument("--page", type=Path, metavar="FILE.md", help=f"page with {page}")
    return parser


def asked_for(given: Namespace, items: list[Item], store: str) -> list[Item]:
    """The runs, with --stored those that are solved already; SceneError where none of them is."""
    if not given.stored:
        return items
    kept = Store(given.output / store).read()
    found = [item for item in items if item.key in kept]
    if not found:
        raise SceneError(f"--stored is not allowed: --output {shown(given.output)} holds nothing that is solved")
    return found


def make_folders(given: Namespace, page: str | None = None) -> Namespace:
    """``given`` with the folders of --output and --page made, once everything else is checked; SceneError where one
    cannot be written, and then none is made.

    page: name of the page in --output where --page names none.
    """
    if page is not None and given.page is None:
        given.page = given.output / page
    made = [] if getattr(given, "output", None) is None else writable(given.output)
    try:
        if getattr(given, "page", None) is not None:
            if given.page.is_dir():
                raise SceneError(f"--page {given.page} is not allowed: a folder, not a file")
            writable(given.page.parent, "--page")
    except SceneError:
        remove_empty(made)
        raise
    return given


def read_map(arguments: list[str], name: str, description: str | None, values: tuple[int, int]) -> Namespace:
    """The checked command line of a map over k and nu. values: how many of each by default; SceneError where wrong."""
    parser = study_parser(name, description, f"results/{name}")
    parser.add_argument("--values", type=int, nargs=2, default=values, metavar=("K", "NU"), help="how many of each")
    given = parser.parse_args(arguments)
    if min(given.values) < 2:
        raise SceneError(f"--values {' '.join(map(str, given.values))} is not allowed: two integers ≥ 2")
    return make_folders(given)
