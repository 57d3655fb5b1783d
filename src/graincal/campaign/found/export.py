"""A campaign's figures for other programs: tables as CSV, or one JSON document."""

from __future__ import annotations

import csv
import io
import math
from collections.abc import Iterable, Mapping, Sequence
from itertools import zip_longest
from pathlib import Path
from typing import Any

import numpy as np

from graincal.campaign.asked.file_names import file_name
from graincal.campaign.found.record import Record
from graincal.campaign.stored.learnt import Learnt
from graincal.campaign.stored.trouble import FolderError
from graincal.data import Failure, InputError, Response
from graincal.notation.printable import printable_json
from graincal.parameter_space import LINEAR


def export_csv(result: Record, folder: Path, *, replace: bool = False) -> list[Path]:
    """Write tables and return their paths.

    samples.csv: each sample with its parameters, errors in percent, those of what was recorded and not fitted too, final weight within its iteration, why it failed, and whether it was stopped early.
    iterations.csv: s, effective sample size and errors of each iteration, or what was learnt of the posterior. responses_EXPERIMENT.csv: every response,
    state by state. posterior.csv: the weighted samples of the emulated posterior, with the method "posterior".
    Raises InputError for files that are there already, unless they are to be replaced.
    """
    pairs = [f"error: {experiment.name}: {name}" for experiment in result.experiments for name in experiment.reference.names]
    beside = [f"error of what is not fitted: {experiment}: {name}" for experiment, name in result.recorded_names]
    weights = np.concatenate([iteration.final_weights for iteration in result.iterations])
    samples = zip(
        result.ids,
        result.iteration,
        *result.samples.T,
        result.errors,
        *result.observable_errors.T,
        *result.recorded_errors.T,
        weights,
        _reasons(result),
        result.stopped.astype(int),
    )
    iterations = [[i.index, len(i.samples), i.failed.sum(), i.s, i.s_per_state, i.effective_sample_size, i.gl_error, i.error] for i in result.iterations]
    figures = ["iteration", "samples", "failed", "s", "s_per_state", "effective_sample_size", "gl_error", "error"]
    if result.has_posterior:
        of_posterior = tuple(Learnt().figures())
        figures = ["iteration", "samples", "failed", "smallest_error", *of_posterior]
        iterations = [
            [i.index, len(i.samples), i.failed.sum(), i.smallest_error, *(getattr(learnt, name) for name in of_posterior)]
            for i, learnt in zip(result.iterations, result.learnt)
        ]
    tables = {
        "samples.csv": (["sample", "iteration", *result.space.names, "error", *pairs, *beside, "weight", "failure", "stopped"], samples),
        "iterations.csv": (figures, iterations),
    }
    if result.has_posterior and (posterior := result.posterior):
        tables["posterior.csv"] = (["weight", *result.space.names], zip(posterior.weights, *posterior.samples.T))
    for experiment in result.experiments:
        tables[f"responses_{file_name(experiment.name)}.csv"] = _responses(result, experiment.name, experiment.reference.control_name)
    return write_files(folder, {name: _as_csv(columns, rows) for name, (columns, rows) in tables.items()}, replace)


def export_json(result: Record, folder: Path, *, replace: bool = False) -> list[Path]:
    """Write campaign.json: what was asked, what was found, and every sample with its responses; numbers that do not exist are null.

    Raises InputError for a file that is there already, unless it is to be replaced.
    """
    space = result.space
    document = {
        "provenance": result.provenance,
        "started": result.started,
        "stopped_by": result.stopped_by,
        "stopped_because": result.stopped_because,
        "grade": {"word": result.grade.word, "reasons": list(result.grade.reasons)} if result.grade else None,
        "parameters": {
            name: {
                "range": [low, high],
                "unit": unit,
                **({"scale": scale} if scale != LINEAR else {}),
                **({} if number is None else {"parameter": parameter, "experiment": result.experiments[number].name}),
            }
            for name, low, high, unit, scale, parameter, number in zip(
                space.names, space.low, space.high, space.units, space.scales, space.parameters, space.experiments
            )
        },
        **({"fixed": {name: {"value": value, "unit": space.units_of_fixed[name]} for name, value in space.fixed.items()}} if space.fixed else {}),
        **({"constraints": list(dict.fromkeys(each.source for each in space.constraints))} if space.constraints else {}),
        "experiments": [
            {
                "name": experiment.name,
                "control": experiment.reference.control_name,
                "reference": {experiment.reference.control_name: experiment.reference.control, **experiment.reference.observables},
                **({"recorded": dict(experiment.reference.recorded)} if experiment.reference.recorded else {}),
                "variance_shares": dict(experiment.reference.variance_shares),
            }
            for experiment in result.experiments
        ],
        "iterations": [
            {
                "index": iteration.index,
                "s": iteration.s,
                "effective_sample_size": iteration.effective_sample_size,
                "gl_error": iteration.gl_error,
                "samples": iteration.samples.ids,
                "weights": iteration.weights,
                **(learnt.figures() if learnt else {}),
            }
            for iteration, learnt in zip_longest(result.iterations, result.learnt)
        ],
        "samples": [
            {"id": id, "iteration": iteration, "theta": theta, "error": error, "failure": reason, "stopped": stopped, "responses": _curves(result, id)}
            for id, iteration, theta, error, reason, stopped in zip(
                result.ids, result.iteration, result.samples, result.errors, _reasons(result), result.stopped
            )
        ],
    }
    return write_files(folder, {"campaign.json": printable_json(_plain(document))}, replace)


def _reasons(result: Record) -> list[str]:
    """Why each sample failed, "" where it did not."""
    reasons = []
    for id, failed in zip(result.ids, result.failed):
        outcomes = [result.response(id, experiment) for experiment in range(len(result.experiments))] if failed else []
        reasons.append(next((f"{outcome.kind}: {outcome.reason}" for outcome in outcomes if isinstance(outcome, Failure)), ""))
    return reasons


def _responses(result: Record, experiment: str, control: str) -> tuple[list[str], list[list[Any]]]:
    columns: dict[str, None] = {}
    rows = []
    for id in result.ids:
        outcome = result.response(id, experiment)
        if isinstance(outcome, Response):
            values = {control: outcome.control} | dict(outcome.values)
            columns |= dict.fromkeys(values)
            rows.append((id, values))
    table = [[id, *(values[name][state] if name in values else "" for name in columns)] for id, values in rows for state in range(len(values[control]))]
    return ["sample", *columns], table


def _curves(result: Record, id: int) -> dict[str, Any]:
    curves = {}
    for experiment in result.experiments:
        outcome = result.response(id, experiment.name)
        if isinstance(outcome, Response):
            curves[experiment.name] = {experiment.reference.control_name: outcome.control} | dict(outcome.values)
    return curves


def _plain(value: Any) -> Any:
    """The value as JSON has it: lists, plain numbers, null for what is not finite."""
    if isinstance(value, dict):
        return {key: _plain(entry) for key, entry in value.items()}
    if isinstance(value, (list, np.ndarray)):
        return [_plain(entry) for entry in value]
    if isinstance(value, np.generic):
        value = value.item()
    return None if isinstance(value, float) and not math.isfinite(value) else value


def _as_csv(columns: Sequence[str], rows: Iterable[Sequence[Any]]) -> str:
    text = io.StringIO()
    csv.writer(text, lineterminator="\n").writerows([columns, *rows])
    return text.getvalue()


def write_files(folder: Path, texts: Mapping[str, str], replace: bool) -> list[Path]:
    """Write texts by their names in the folder, made where it is not there, and return the paths. Raises InputError for files that are there already, unless they are to be replaced."""
    paths = [folder / name for name in texts]
    if not replace and (there := [path for path in paths if path.exists()]):
        raise InputError(f"{there[0]}: this file is there already and is not overwritten; name another folder.")
    for path, text in zip(paths, texts.values()):
        try:
            folder.mkdir(parents=True, exist_ok=True)
            path.write_text(text, encoding="utf-8", errors="backslashreplace")
        except OSError as error:
            raise FolderError.of(path, error) from error
    return paths
