"""The scene language for readers and editors, from the models:  python -m simulations.scene.documentation.

It writes the table of keys into docs/scene.md and the JSON schema docs/scene.schema.json.
"""

import json
import sys
from dataclasses import astuple
from pathlib import Path
from typing import Any, Literal, get_args, get_origin

from annotated_types import Ge, Gt, Le, Lt

from .fields import ListOf, Word, allowed, alternatives, longest, unit
from .scene import Scene
from .table import KINDS, Table, fields
from .tables import ONE_OF_TWO
from .text import table_row

DOCS = Path(__file__).resolve().parents[2] / "docs"
PAGE, SCHEMA = DOCS / "scene.md", DOCS / "scene.schema.json"
BEGIN, END = "<!-- keys: written by python -m simulations.scene.documentation -->\n", "<!-- end of keys -->\n"


def table_of_keys() -> str:
    """The table of all keys in Markdown: unit, what is allowed, default, meaning."""
    lines = ["| key | unit | allowed | default | meaning |", "|---|---|---|---|---|"]
    for key, found in ({"title": [Scene.model_fields["title"]]} | fields()).items():
        default = "" if found[0].is_required() or found[0].default is None else f"`{json.dumps(found[0].default)}`"
        meaning = "; ".join(dict.fromkeys(field.description for field in found if field.description))
        lines.append(table_row((f"`{key}`", unit(found[0]), allowed(*found), default, meaning)))
    return "\n".join(lines) + "\n"


def page(text: str) -> str:
    """The text of docs/scene.md with its table of keys renewed."""
    head, rest = text.split(BEGIN)
    return head + BEGIN + table_of_keys() + END + rest.split(END)[1]


def schema() -> dict[str, Any]:
    """The JSON schema of a scene file, for completion in editors."""
    found = Scene.model_json_schema()
    for kinds in KINDS.values():
        for kind in kinds:
            _as_it_is_written(found["$defs"][kind.__name__], kind, is_default=kind is kinds[0])
    for name, kinds in KINDS.items():
        options = [{"$ref": f"#/$defs/{kind.__name__}"} for kind in kinds]
        found["properties"][name] = {"anyOf": options} if len(options) > 1 else options[0]
    found["properties"]["title"].pop("title", None)
    return {"$schema": "http://json-schema.org/draft-07/schema#"} | found


def _as_it_is_written(definition: dict[str, Any], kind: type[Table], is_default: bool):
    """Adapt a model's schema to text: no null, words for numbers, one of two lengths, units in the descriptions."""
    if kind.tag and not is_default:  # without the word, the table is the default model
        definition["required"] = [kind.tag, *definition.get("required", [])]
    pairs = [pair for pair in ONE_OF_TWO if kind.table == "solid" and pair[0] in kind.model_fields]
    if pairs:
        definition["allOf"] = [{"oneOf": [{"required": [name]} for name in pair]} for pair in pairs]
    for name, field in kind.model_fields.items():
        options = []
        for base, marks in alternatives(field):
            options.append(_option(base, marks))
            options += [{"const": mark.text} for mark in marks if isinstance(mark, Word)]
        entry: dict[str, Any] = options[0] if len(options) == 1 else {"anyOf": options}
        in_unit = unit(field) if entry.get("type") in ("number", "array") else ""
        entry["description"] = ", ".join(filter(None, (field.description, in_unit.replace("–", ""))))
        if not field.is_required() and field.default is not None:
            entry["default"] = field.default
        definition["properties"][name] = entry


def _option(base, marks) -> dict[str, Any]:
    """The schema of one type that a field takes."""
    if base is bool:
        return {"type": "boolean"}
    if base is str:
        return {"type": "string", "maxLength": longest(marks)}
    if base in (int, float):
        option: dict[str, Any] = {"type": "integer" if base is int else "number"}
        bounds = {Gt: "exclusiveMinimum", Ge: "minimum", Lt: "exclusiveMaximum", Le: "maximum"}
        for mark in marks:
            if type(mark) in bounds:
                (option[bounds[type(mark)]],) = astuple(mark)
        return option
    words = get_args(base)
    if get_origin(base) is Literal:
        return {"enum": list(words)}
    (kind,) = (mark for mark in marks if isinstance(mark, ListOf))
    return {"type": "array", "items": kind.item, "minItems": kind.least}


def written() -> dict[Path, str]:
    """What the files hold when they are up to date."""
    in_json = json.dumps(schema(), indent=1, ensure_ascii=False)
    return {PAGE: page(PAGE.read_text(encoding="utf-8")), SCHEMA: in_json + "\n"}


def main(arguments: list[str]):
    """Write the files."""
    if arguments:
        sys.exit("python -m simulations.scene.documentation takes no arguments")
    for path, text in written().items():
        path.write_text(text, encoding="utf-8")


if __name__ == "__main__":
    main(sys.argv[1:])
