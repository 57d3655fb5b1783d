"""The directive `graincal-keys`: every key of a calibration file, from the declarations that its reader uses."""

import json
from collections import defaultdict
from collections.abc import Iterator
from typing import Any

from docutils import nodes
from docutils.parsers.rst import Directive
from pydantic import BaseModel
from pydantic.fields import FieldInfo
from sphinx.application import Sphinx

from graincal.campaign.file.blocks import BlocksSection
from graincal.campaign.file.config import CalibrationFile
from graincal.campaign.file.experiments import ExperimentEntry, Observable, ReferenceFile
from graincal.campaign.file.look import LookSection
from graincal.campaign.file.models import MODELS
from graincal.campaign.file.options import FilterSection, RunSection, StopSection
from graincal.campaign.file.output import ColumnTable, OutputSection
from graincal.campaign.file.parameters import ConstraintEntry, Parameter

HEAD = ("key", "what is expected", "default")


class Keys(Directive):
    """A section with a table of keys for each place of a calibration file."""

    def run(self) -> list[nodes.Node]:
        return [_section(place, table) for place, table in places()]


def places() -> Iterator[tuple[str, type[BaseModel]]]:
    """Where a table stands in a file, and its declaration, in the order of a file."""
    yield "The file", CalibrationFile
    yield "[parameters], a parameter", Parameter
    yield "[[constraint]]", ConstraintEntry
    yield "[[experiment]]", ExperimentEntry
    yield "[[experiment]] observables, an observable", Observable
    yield "[experiment.reference]", ReferenceFile
    kinds = defaultdict(list)
    for kind, table in MODELS.items():
        kinds[table].append(f'"{kind}"')
    for table, named in kinds.items():
        yield f"[experiment.model], kind = {' or '.join(named)}", table
    yield "[experiment.model] output", OutputSection
    yield "[experiment.model] output columns, a column", ColumnTable
    yield "[filter]", FilterSection
    yield "[first_look]", LookSection
    yield "[stop]", StopSection
    yield "[run]", RunSection
    yield "[run.parsl]", BlocksSection


def _section(place: str, table: type[BaseModel]) -> nodes.section:
    section = nodes.section(ids=[nodes.make_id(place)], names=[nodes.fully_normalize_name(place)])
    section += nodes.title(text=place)
    rows = [(nodes.literal(text=key), nodes.inline(text=field.description or ""), _default(field)) for key, field in table.model_fields.items()]
    section += _table(rows)
    return section


def _default(field: FieldInfo) -> nodes.Node:
    if field.is_required():
        return nodes.inline(text="required")
    if field.default in (None, "", [], {}) or isinstance(field.default, BaseModel):
        return nodes.inline(text="none")
    return nodes.literal(text=json.dumps(field.default, ensure_ascii=False))


def _table(rows: list[tuple[nodes.Node, ...]]) -> nodes.table:
    group = nodes.tgroup("", *(nodes.colspec(colwidth=width) for width in (20, 60, 20)), cols=len(HEAD))
    group += nodes.thead("", _row([nodes.inline(text=each) for each in HEAD]))
    group += nodes.tbody("", *map(_row, rows))
    return nodes.table("", group)


def _row(cells: Any) -> nodes.row:
    return nodes.row("", *(nodes.entry("", nodes.paragraph("", "", cell)) for cell in cells))


def setup(sphinx: Sphinx) -> dict[str, bool]:
    sphinx.add_directive("graincal-keys", Keys)
    return {"parallel_read_safe": True, "parallel_write_safe": True}
