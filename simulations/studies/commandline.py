"""The command line that all studies share: -h, --version, --output, --page, and one line for whatever is wrong."""

from argparse import Namespace
from pathlib import Path

from ..command.command import Parser, writable
from ..scene import SceneError
from ..version import __version__


def study_parser(name: str, description: str | None, output: str | None = None, page: str | None = None) -> Parser:
    """Parser of ``python -m simulations.studies.NAME``. output: default folder; page: what its page holds."""
    program = f"python -m simulations.studies.{name}"
    parser = Parser(prog=program, description=description, allow_abbrev=False, conflict_handler="resolve")
    parser.add_argument("--version", action="version", version=f"graded-fretting {__version__}")
    if output is not None:
        parser.add_argument(
            "--output", type=Path, default=Path(output), metavar="DIR", help=f"folder for results (default: {output})"
        )
    if page is not None:
        parser.add_argument("--page", type=Path, metavar="FILE.md", help=f"{page}, as a page")
    return parser


def make_folders(given: Namespace):
    """The folders of --output and --page, once everything else is checked; SceneError where one cannot be written."""
    if getattr(given, "output", None) is not None:
        given.output = writable(given.output)
    page = getattr(given, "page", None)
    if page is not None:
        if page.is_dir():
            raise SceneError(f"--page {page} is not allowed: a folder, not a file")
        writable(page.parent, "--page")
