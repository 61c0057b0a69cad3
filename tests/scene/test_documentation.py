"""docs/scene.md and the JSON schema say what the models say."""

import tomllib

import pytest
from running import ROOT

from simulations.scene import documentation, language, parse

FILES = sorted((ROOT / "scenes").glob("*.toml"))


@pytest.mark.parametrize("path", documentation.written(), ids=lambda path: path.name)
def test_files_are_up_to_date(path):
    renewed = documentation.written()[path]
    assert path.read_text() == renewed, "python -m simulations.scene.documentation renews it"


def test_every_key_has_a_meaning():
    rows = [row.split(" | ") for row in documentation.table_of_keys().splitlines()[2:]]
    assert [row[0].strip("| `") for row in rows] == list(language())
    assert all(row[-1].strip("| ") for row in rows)


@pytest.mark.parametrize("path", FILES, ids=[path.stem for path in FILES])
@pytest.mark.parametrize("resolved", [False, True])
def test_scenes_fit_the_schema(path, resolved):
    """As they are written and as a run writes them."""
    text = path.read_text()
    check(tomllib.loads(parse(text).to_toml() if resolved else text), documentation.schema())


@pytest.mark.parametrize(
    "table, entries",
    [
        ("solid", {"y0": 1.0}),
        ("solid", {"modulus": "linear"}),
        ("solid", {"nu": "hall"}),
        ("load", {"Q_A": 1.0}),
        ("mesh", {"degree": 4}),
        ("quark", {}),
    ],
)
def test_other_texts_do_not(table, entries):
    document = tomllib.loads((ROOT / "scenes" / "holl.toml").read_text())
    document[table] = document.get(table, {}) | entries
    with pytest.raises(AssertionError):
        check(document, documentation.schema())


def check(value, schema, definitions=None):
    """Assert that a value fits a schema: those words of the standard that the schema has, and no other."""
    definitions = definitions or schema["$defs"]
    kinds = {"object": dict, "array": list, "string": str, "boolean": bool, "integer": int, "number": (int, float)}
    for word, wanted in schema.items():
        match word:
            case "$ref":
                check(value, definitions[wanted.rpartition("/")[2]], definitions)
            case "type":
                assert isinstance(value, kinds[wanted]) and (wanted == "boolean" or not isinstance(value, bool)), value
            case "enum":
                assert value in wanted
            case "const":
                assert value == wanted
            case "anyOf" | "oneOf":
                fitting = sum(fits(value, option, definitions) for option in wanted)
                assert fitting == 1 if word == "oneOf" else fitting, value
            case "allOf":
                assert all(fits(value, option, definitions) for option in wanted), value
            case "properties":
                assert schema["additionalProperties"] is False and set(value) <= set(wanted), value
                for name in value:
                    check(value[name], wanted[name], definitions)
            case "required":
                assert set(wanted) <= set(value), value
            case "items":
                for item in value:
                    check(item, wanted, definitions)
            case "minItems":
                assert len(value) >= wanted
            case "maxItems" | "maxLength":
                assert len(value) <= wanted
            case "minimum":
                assert value >= wanted
            case "maximum":
                assert value <= wanted
            case "exclusiveMinimum":
                assert value > wanted
            case "exclusiveMaximum":
                assert value < wanted
            case _:
                assert word in ("$schema", "$defs", "additionalProperties", "title", "description", "default"), word


def fits(value, schema, definitions) -> bool:
    """True where ``check`` finds nothing."""
    try:
        check(value, schema, definitions)
    except AssertionError:
        return False
    return True
