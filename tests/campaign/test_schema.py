"""The JSON schema for editors agrees with what is read."""

import json
import re
import tomllib
from pathlib import Path

import pytest

jsonschema = pytest.importorskip("jsonschema", reason="jsonschema is not installed")

ROOT = Path(__file__).parents[2]
EXAMPLES = sorted(ROOT.glob("examples/*/*.toml"))
WRITTEN = [
    (page.name, block)
    for page in sorted([ROOT / "README.md", *ROOT.glob("docs/*.md")])
    for block in re.findall(r"^```toml\n(.*?)^```", page.read_text(encoding="utf-8"), re.M | re.S)
]


@pytest.fixture
def schema(call):
    found = json.loads(call("schema").out)
    jsonschema.Draft202012Validator.check_schema(found)
    return found


def mistakes(schema, content):
    return [f"{error.json_path}: {error.message}" for error in jsonschema.Draft202012Validator(schema).iter_errors(content)]


def test_the_examples_are_what_it_says(schema):
    assert EXAMPLES and not {file.parent.name: found for file in EXAMPLES if (found := mistakes(schema, tomllib.loads(file.read_text(encoding="utf-8"))))}


def test_whole_files_in_documents_are_what_it_says(schema):
    whole = [(page, content) for page, block in WRITTEN if {"parameters", "experiment"} <= set(content := tomllib.loads(block))]
    assert whole and not [(page, found) for page, content in whole if (found := mistakes(schema, content))]


def test_parts_of_files_in_documents_are_what_it_says(schema):
    # A part may leave out what the file has elsewhere.
    parts = schema | {"required": [], "$defs": {name: table | {"required": []} for name, table in schema["$defs"].items()}}
    found = {}
    for page, block in WRITTEN:
        try:
            content = tomllib.loads(block)
        except tomllib.TOMLDecodeError:
            continue
        for key, value in content.items():
            if key in ("parameters", "constraint", "filter", "stop", "run", "first_look") and (wrong := mistakes(parts, {key: value})):
                found[page, key] = wrong
    assert not found


@pytest.mark.parametrize(("key", "value"), [("filter", {"alhpa": 3}), ("stop", {"s": "small"}), ("run", {"workers": 0}), ("run", {"executor": 3})])
def test_mistakes_are_seen(schema, key, value):
    content = tomllib.loads(EXAMPLES[0].read_text(encoding="utf-8"))
    assert mistakes(schema, content | {key: value})


def test_the_keys_of_a_model_are_those_of_its_kind(schema):
    content = tomllib.loads((ROOT / "examples" / "triaxial" / "calibration.toml").read_text(encoding="utf-8"))
    model = content["experiment"][0]["model"]
    content["experiment"][0]["model"] = model | {"confining_pressure": "?"}
    assert not mistakes(schema, content)
    content["experiment"][0]["model"] = model | {"command": ["a"]}
    assert mistakes(schema, content)
