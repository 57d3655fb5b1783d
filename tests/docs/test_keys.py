"""Every key of a calibration file is told of: in the table that is made of the declarations, and where it is explained."""

import importlib.util
import re
from pathlib import Path

import pytest

from graincal.campaign.file.schema import json_schema

pytest.importorskip("sphinx", reason="the site is built by Sphinx (pip install '.[docs]')")
DOCS = Path(__file__).parents[2] / "docs"


@pytest.fixture(scope="module")
def places():
    spec = importlib.util.spec_from_file_location("keys", DOCS / "_extensions" / "keys.py")
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    return dict(module.places())


def test_every_table_of_the_schema_has_its_place(places):
    # The one that is left out is what models of all kinds have in common.
    assert {table.__name__ for table in places.values()} == set(json_schema()["$defs"]) - {"ModelSection"}


def test_every_key_is_explained(places):
    explained = (DOCS / "calibration-file.md").read_text()
    missing = [f"{place}: {key}" for place, table in places.items() for key in table.model_fields if not re.search(rf"(`|\[|\[run\.|[{{,] ){key}\b", explained)]
    assert missing == []
