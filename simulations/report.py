"""One page about a run that a person can read, print on two sheets and send on:  python -m simulations.report DIR."""

import base64
import html
import json
from pathlib import Path

from .command.arguments import Parser
from .command.command import on_root, run, say
from .output import page_figures as figures
from .output.body_states import read_states
from .output.files import reading, rows_of, write_text
from .output.folder import REPORT, lost_file, refuse_changed
from .output.page_words import CHECKS, FIELDS, PHASES, QUANTITIES, asked, quantity
from .output.style import left_out, spread
from .scene import SceneError, parse, shown

SHOWN_STATES = 6  # of the body
STYLE = """body{font:15px/1.45 sans-serif;max-width:64em;margin:2em auto;padding:0 1em;color:#222}
h1{font-size:1.5em}h2{font-size:1.1em;margin:1.2em 0 .2em}p{margin:.3em 0}
table{border-collapse:collapse;margin:.3em 0;width:100%}td,th{border-bottom:1px solid #ddd;text-align:left}
td,th{padding:.12em .8em .12em 0}td.n,th.n{text-align:right;font-variant-numeric:tabular-nums;white-space:nowrap}
pre{background:#f5f5f5;padding:.8em;white-space:pre-wrap}
img{width:100%;margin:.3em 0}img.beside{max-height:42em;width:auto;max-width:100%}.bad{color:#a00;font-weight:bold}
.small{color:#555;font-size:.9em}details table{font-size:.8em}
@page{size:A4;margin:12mm 14mm}
@media print{body{font-size:10.5px;line-height:1.3;margin:0;padding:0;max-width:none}details{display:none}
h2{break-after:avoid}img,tr{break-inside:avoid}.second{break-before:page}
img.beside{max-height:76mm}}"""


def main(arguments: list[str]):
    """Read the folder, write its page."""
    say(f"written: {on_root(lambda: write(read(arguments)))}")


def write(folder: Path) -> Path:
    """Make the page of ``folder``; SceneError where it cannot be written."""
    text = page(folder)
    try:
        write_text(folder / REPORT, text)
    except OSError as error:
        raise SceneError(f"{shown(folder / REPORT)} cannot be written: {error.strerror}") from None
    return folder / REPORT


def read(arguments: list[str]) -> Path:
    """The folder that the command line names; SceneError where its files are not all there, or of another scene."""
    parser = Parser(prog="python -m simulations.report", description=__doc__)
    parser.add_argument("folder", type=Path, metavar="DIR", help="folder of a run")
    folder = parser.parse_args(arguments).folder
    lost = lost_file(folder)
    if lost:
        raise SceneError(f"{shown(folder)} does not hold the whole of a run that ended: {lost} is missing")
    refuse_changed(folder)
    return folder


def page(folder: Path) -> str:
    """The page as HTML; everything it shows is in it. SceneError where the files are not those of a run."""
    try:
        with reading(folder / "summary.json") as path:
            summary = json.loads(path.read_text(encoding="utf-8"))
        rows = rows_of(folder / "history.csv")
        scene = (folder / "scene.toml").read_text(encoding="utf-8")
        words = asked(parse(scene, name=f"scene {shown(folder / 'scene.toml')}"))
        title = summary["title"] or folder.resolve().name  # also of "."
        parts = [_verdict(summary), "<h2>What was asked</h2>", *map(_paragraph, words)]
        parts += ["<h2>What was found</h2>", _found(summary), _fields(summary), "<h2>Checks</h2>", _checks(summary)]
        if (folder / "fretting.png").is_file():
            has_lines = summary.get("errors") or summary.get("differences")
            lines = " on the lines of what the run is compared with" if has_lines else ""
            parts.append(f"<h2>Computed points{lines}</h2>")
            parts.append(_image((folder / "fretting.png").read_bytes(), "computed points", "beside"))
        parts += [_surface(folder, rows), _body(folder, rows), "<h2>How it was solved</h2>", _solved(summary)]
        parts.append(_history(rows))
        parts.append(f"<details><summary>Scene</summary><pre>{html.escape(scene)}</pre></details>")
    except (KeyError, IndexError, TypeError, AttributeError, ValueError, OSError) as error:
        raise SceneError(f"{shown(folder)}: its files are not those of a run: {error!r}") from None
    head = f"<meta charset='utf-8'><title>{html.escape(title)}</title><style>{STYLE}</style>"
    body = f"<h1>{html.escape(title)}</h1>{''.join(parts)}"
    return f"<!doctype html><html lang='en'><head>{head}</head><body>{body}</body></html>"


def _verdict(summary):
    warnings = "".join(f"<p class='bad'>Warning: {html.escape(words)}</p>" for words in summary.get("warnings", ()))
    if not summary["converged"]:
        return f"<p class='bad'>Did not reach its end: {html.escape(str(summary['failure']))}</p>{warnings}"
    steps = f"All load steps converged ({summary['increments']})"
    if summary["checks_hold"]:
        return f"<p>{steps}, and all checks of the result hold.</p>{warnings}"
    return f"<p class='bad'>{steps}, but checks of the result fail (see below).</p>{warnings}"


def _found(summary):
    """Scalars of the last state and cycle, beside those of the reference and of closed forms without some physics."""
    kinds = {
        "errors": ("reference_values", "reference", "relative error"),
        "differences": ("differences_values", "closed form", "relative difference"),
    }
    beside = [(summary[kind], *words) for kind, words in kinds.items() if summary.get(kind)]
    table = [["last state and cycle", "computed", *(word for _, _, *heads in beside for word in heads)]]
    for name, (words, unit) in QUANTITIES.items():
        if name in summary:
            row = [words, quantity(summary[name], unit)]
            for deviations, key, *_ in beside:
                share, value = deviations.get(name), summary.get(key, {}).get(name)
                row += [quantity(value, unit), "–" if share is None else f"{share:+.1e}"]
            table.append(row)
    notes = []
    if summary.get("errors"):
        notes.append(f"Reference: {summary['reference']}.")
    elif "reference" in summary:
        notes.append(f"There is no reference, because {summary['reference'].removeprefix('none: ')}.")
    if summary.get("differences"):
        notes.append(f"Differences are from the {summary['differences_from']}.")
    return (_table(table) if len(table) > 1 else "<p>No result.</p>") + _paragraph(" ".join(notes), "small")


def _fields(summary):
    """Deviations of the fields over the contact, at the last and at the worst state."""
    table = [["relative deviation in L2 over the contact", "last state", "worst state"]]
    for kind, word in (("errors", "error"), ("differences", "difference")):
        for name, field in FIELDS.items():
            if name in (summary.get(kind) or {}):
                worst = summary[f"{kind}_worst_state"][name]
                table.append([f"{word} of the {field}", f"{summary[kind][name]:.1e}", f"{worst:.1e}"])
    return _table(table) if len(table) > 1 else ""


def _checks(summary):
    if not summary.get("checks"):
        return "<p>The run did not reach its end: nothing was checked.</p>"
    table, causes = [["", "value", "limit", ""]], []
    for name, check in summary["checks"].items():
        numbers = ("none" if v is None else f"{abs(v):.1e}" if v else "0" for v in (check["value"], check["limit"]))
        table.append([CHECKS.get(name, name), *numbers, "holds" if check["holds"] else "fails"])
        if not check["holds"] and check.get("cause"):
            causes.append(_paragraph(f"{CHECKS.get(name, name)}: {check['cause']}", "bad"))
    return _table(table) + "".join(causes)


def _surface(folder, rows):
    image = figures.surface(folder, rows)
    if image is None:
        return ""
    title = "<h2 class='second'>On the surface</h2>"
    note = "Letters and dots are states of the last cycle: A at its end, B to E on the way from +Q_A to −Q_A."
    lettered = any(row["state"] == "E" for row in rows)
    return title + _image(image, "pressure, traction, slip and friction loop") + _paragraph(note * lettered, "small")


def _body(folder, rows):
    """Von Mises stress below the contact at the recorded states; nothing where the run has none."""
    try:
        states = {state.label.partition(",")[0]: state for state in read_states(folder)}
    except SceneError:  # no fields, or other ones were asked for
        return ""
    drawn = spread([*states.values()], SHOWN_STATES)
    note = _paragraph(left_out(len(drawn), len(states)), "small")
    image = _image(figures.body(drawn, rows), "von Mises stress below the contact at recorded states")
    return "<h2>Stress in the body</h2>" + image + note


def _solved(summary):
    sizes = f"{summary['dofs']} unknowns on {summary['ranks']} rank(s); {summary['increments']} load steps took "
    sizes += f"{summary['newton_iterations']} Newton iterations and were halved {summary['cuts']} times."
    if summary.get("largest_unsettled"):
        sizes += f" Anchors did not settle in all of them: to {summary['largest_unsettled']:.1%} of the motion."
    if summary.get("resumed"):
        sizes += f" The run was resumed {summary['resumed']} times."
    seconds = "; ".join(f"{PHASES.get(phase, phase)} {s:.1f}" for phase, s in summary["seconds"].items())
    versions = ", ".join(f"{name} {version}" for name, version in summary["versions"].items())
    return "".join(map(_paragraph, (sizes, f"Seconds: {seconds}.", f"Versions: {versions}.")))


def _history(rows):
    table = _table([list(rows[0]), *(list(row.values()) for row in rows)])
    image = _image(figures.convergence(rows), "Newton iterations and residuals")
    return f"<details><summary>Every load step</summary>{image}{table}</details>"


def _paragraph(text, kind=""):
    return f"<p class='{kind}'>{html.escape(text)}</p>" if text else ""


def _table(rows):
    """rows: texts, the first row the heads; the first column is text, the others are numbers."""
    lines = []
    for tag, row in zip(["th"] + ["td"] * len(rows), rows):
        cells = (f"<{tag}{' class=n' if i else ''}>{html.escape(str(text))}</{tag}>" for i, text in enumerate(row))
        lines.append(f"<tr>{''.join(cells)}</tr>")
    return f"<table>{''.join(lines)}</table>"


def _image(content: bytes, name: str, kind: str = ""):
    return f"<img class='{kind}' alt='{name}' src='data:image/png;base64,{base64.b64encode(content).decode()}'>"


if __name__ == "__main__":
    run(main)
