"""One self-contained page about a finished or stopped run:  python -m simulations.report DIR."""

import base64
import csv
import html
import io
import json
from pathlib import Path

import matplotlib.pyplot as plt

from .command.command import Parser, on_root, run, say
from .output.files import write_text
from .scene import SceneError, shown

PAGE = "report.html"
STYLE = """body{font:15px/1.5 sans-serif;max-width:62em;margin:2em auto;padding:0 1em;color:#222}
table{border-collapse:collapse;margin:.5em 0}td,th{border-bottom:1px solid #ddd;text-align:left}
td,th{padding:.15em .8em .15em 0}
td.n{text-align:right;font-variant-numeric:tabular-nums}pre{background:#f5f5f5;padding:.8em;overflow-x:auto}
img{max-width:100%}.bad{color:#a00;font-weight:bold}"""


def main(arguments: list[str]):
    """Read the folder, write its page."""
    say(f"written: {on_root(lambda: write(read(arguments)))}")


def write(folder: Path) -> Path:
    """Make the page of ``folder``; SceneError where it cannot be written."""
    text = page(folder)
    try:
        write_text(folder / PAGE, text)
    except OSError as error:
        raise SceneError(f"{shown(folder / PAGE)} cannot be written: {error.strerror}") from None
    return folder / PAGE


def read(arguments: list[str]) -> Path:
    """The folder that the command line names; SceneError where it holds no results."""
    parser = Parser(prog="python -m simulations.report", description=__doc__, allow_abbrev=False)
    parser.add_argument("folder", type=Path, metavar="DIR", help="folder of a run")
    folder = parser.parse_args(arguments).folder
    for name in ("scene.toml", "summary.json", "history.csv"):
        if not (folder / name).is_file():
            raise SceneError(f"{shown(folder)} is not the folder of a run that ended: {name} is missing")
    return folder


def page(folder: Path) -> str:
    """The page as HTML; everything it shows is in it."""
    try:
        summary = json.loads((folder / "summary.json").read_text(encoding="utf-8"))
        with open(folder / "history.csv", newline="", encoding="utf-8") as file:
            rows = list(csv.DictReader(file))
        scene = (folder / "scene.toml").read_text(encoding="utf-8")
        title = summary["title"] or folder.name
        parts = [_verdict(summary), _results(summary), _errors(summary)]
        if (folder / "fretting.png").is_file():
            parts.append(_image((folder / "fretting.png").read_bytes(), "pressure, traction and friction loop"))
        parts += ["<h2>Effects</h2>", _effects(summary)]
        parts += ["<h2>Convergence</h2>", _image(_convergence(rows), "convergence")]
        parts += [_history(rows), "<h2>Scene</h2>", f"<pre>{html.escape(scene)}</pre>"]
        parts += ["<h2>Versions and seconds</h2>", _table(summary["versions"]), _table(summary["seconds"])]
    except (KeyError, IndexError, TypeError, AttributeError, ValueError, OSError) as error:
        raise SceneError(f"{shown(folder)}: its files are not those of a run: {error!r}") from None
    head = f"<meta charset='utf-8'><title>{html.escape(title)}</title><style>{STYLE}</style>"
    body = f"<h1>{html.escape(title)}</h1>{''.join(parts)}"
    return f"<!doctype html><html lang='en'><head>{head}</head><body>{body}</body></html>"


def _verdict(summary):
    sizes = f"{summary['increments']} increments, {summary['newton_iterations']} Newton iterations"
    sizes += f", {summary['cuts']} cuts, {summary['dofs']} unknowns on {summary['ranks']} rank(s)"
    resumed = f", resumed {summary['resumed']} times" if summary.get("resumed") else ""
    if summary["converged"]:
        return f"<p>Converged: {sizes}{resumed}.</p>"
    return f"<p class='bad'>Did not reach its end: {html.escape(str(summary['failure']))}</p><p>{sizes}{resumed}.</p>"


def _results(summary):
    names = {
        "a": "contact half-width a [m]",
        "a_over_a0": "a/a0",
        "c_over_a": "stick half-width c/a",
        "indentation": "indentation [m]",
        "dissipated_energy": "dissipated energy of the last cycle [J/m]",
    }
    return _table({label: summary[name] for name, label in names.items() if name in summary})


def _errors(summary):
    parts = []
    for kind, label in (("errors", "reference"), ("differences", "differences_from")):
        if summary.get(kind):
            text = f"Relative {kind}, {summary[label]}"
            parts.append(f"<h2>{kind.capitalize()}</h2><p>{html.escape(text)}</p>{_table(summary[kind])}")
    return "".join(parts) or f"<p>No errors: reference {html.escape(str(summary.get('reference', 'none')))}.</p>"


def _effects(summary):
    return _table({name: "on" if on else "off" for name, on in summary["effects"].items()})


def _convergence(rows) -> bytes:
    numbers = [int(row["increment"]) for row in rows]
    figure, (left, right) = plt.subplots(1, 2, figsize=(10, 3), layout="constrained")
    left.bar(numbers, [int(row["iterations"]) for row in rows])
    left.set(xlabel="increment", ylabel="Newton iterations")
    right.semilogy(numbers, [max(float(row["residual"]), 1e-17) for row in rows], "o-")
    right.set(xlabel="increment", ylabel="force residual / P")
    image = io.BytesIO()
    figure.savefig(image, dpi=110)
    plt.close(figure)
    return image.getvalue()


def _history(rows):
    head = "".join(f"<th>{html.escape(name)}</th>" for name in rows[0])
    body = "".join(f"<tr>{''.join(f'<td>{html.escape(value)}</td>' for value in row.values())}</tr>" for row in rows)
    return f"<details><summary>Every increment</summary><table><tr>{head}</tr>{body}</table></details>"


def _table(values):
    def written(value):
        return f"{value:.6g}" if isinstance(value, float) else str(value)

    cells = ((html.escape(str(name)), html.escape(written(value))) for name, value in values.items())
    return f"<table>{''.join(f'<tr><td>{name}</td><td class=n>{value}</td></tr>' for name, value in cells)}</table>"


def _image(content: bytes, name: str):
    return f"<img alt='{name}' src='data:image/png;base64,{base64.b64encode(content).decode()}'>"


if __name__ == "__main__":
    run(main)
