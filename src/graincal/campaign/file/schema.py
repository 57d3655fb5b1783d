"""The JSON schema of a calibration file, for editors: made of the declarations that the reader itself uses."""

from __future__ import annotations

from typing import Any

from pydantic import BaseModel
from pydantic.json_schema import models_json_schema

from graincal.campaign.file.config import CalibrationFile
from graincal.campaign.file.experiments import ExperimentEntry
from graincal.campaign.file.models import MODELS
from graincal.campaign.file.output import OutputSection

_QUESTION = {"const": "?", "description": "an open question, to be answered before it is calibrated"}


def json_schema() -> dict[str, Any]:
    """The schema. Any value may be the open question "?". What keys say together, such as packing or particles, is for `graincal check`."""
    kinds = list(dict.fromkeys(MODELS.values()))
    read: list[type[BaseModel]] = [CalibrationFile, *kinds]
    places, document = models_json_schema([(each, "validation") for each in read], ref_template="#/$defs/{model}")
    tables = document["$defs"]
    entry = tables[ExperimentEntry.__name__]["properties"]
    # The reader finds a model's table by its kind, and takes the name of a file alone for a reference, and that of a column for a column.
    entry["model"] = {
        "type": "object",
        "required": ["kind"],
        "properties": {"kind": {"enum": list(MODELS)}},
        "allOf": [_of_kind(kind, places[model, "validation"]) for kind, model in MODELS.items()],
    }
    entry["reference"] = {"anyOf": [{"type": "string"}, *entry["reference"]["anyOf"]]}
    columns = tables[OutputSection.__name__]["properties"]["columns"]
    columns["additionalProperties"] = {"anyOf": [{"type": ["string", "integer"]}, columns["additionalProperties"]]}
    for table in tables.values():
        table["properties"] = {key: _or_question(value) for key, value in table.get("properties", {}).items()}
    return {
        "$schema": "https://json-schema.org/draft/2020-12/schema",
        "title": "graincal calibration file",
        **places[CalibrationFile, "validation"],
        "$defs": tables,
    }


def _of_kind(kind: str, table: dict[str, Any]) -> dict[str, Any]:
    return {"if": {"properties": {"kind": {"const": kind}}, "required": ["kind"]}, "then": table}


def _or_question(value: dict[str, Any]) -> dict[str, Any]:
    """The value of a key, or the open question; what is said of the key stays where editors look for it."""
    said = {key: value[key] for key in ("title", "description", "default") if key in value}
    return said | {"anyOf": [{key: each for key, each in value.items() if key not in said}, _QUESTION]}
