"""The report's tables: rows of text in markup."""

from __future__ import annotations

from dataclasses import asdict, dataclass
from datetime import datetime, timezone

from graincal.campaign import Experiment, Result
from graincal.models import StressPathTest
from graincal.models.stress_path import PRECISIONS
from graincal.report import numbers
from graincal.report.findings import PROBABILITY, Finding
from graincal.report.groups import find_groups
from graincal.report.quantities import parameters, quantity
from graincal.report.run_times import failure_kinds


@dataclass(frozen=True)
class Table:
    """A table: its head and its rows, of equal length. Columns from `figures` on hold figures."""

    head: tuple[str, ...]
    rows: tuple[tuple[str, ...], ...]
    figures: int = 1


def of_parameters(result: Result, findings: tuple[Finding, ...]) -> Table:
    """Each parameter: range, truth where one is known, values that fit about as well, moments, interval, the best and the most probable value."""
    head = ["parameter", "range"] + (["truth"] if result.truth else [])
    if findings:
        head += ["fit about as well", f"{100 * PROBABILITY:.0f} % interval", "mean ± sd", "sd / range's sd", "verdict"]
    candidates = {name: candidate for name, candidate in (("best", result.best), ("most probable", result.most_probable)) if candidate}
    head += candidates
    rows = []
    for k, shown in enumerate(parameters(result.space)):
        row = [shown.axis, f"{numbers.short(result.space.low[k])} to {numbers.short(result.space.high[k])}"]
        if result.truth:
            truth = result.truth.get(result.space.names[k])
            row.append("–" if truth is None else numbers.short(truth))
        if findings:
            found = findings[k]
            row += [numbers.between(*found.close) if found.outlined else "–", numbers.between(found.low, found.high)]
            row += [numbers.estimate(found.mean, found.std), f"{found.spread:.2f}", f"{found.verdict}, away from the truth" if found.astray else found.verdict]
        row += [numbers.value(candidate.theta[k]) for candidate in candidates.values()]
        rows.append(tuple(row))
    return Table(tuple(head), tuple(rows))


def of_groups(result: Result) -> Table | None:
    """The separate groups that carry the weight: their shares and centres; None for a single one."""
    groups = find_groups(result.space, result.posterior) if result.posterior else ()
    rows = [(f"{100 * group.share:.0f} %", *(numbers.value(value) for value in group.centre)) for group in groups]
    head = ("share of the weight", *(shown.axis for shown in parameters(result.space)))
    return Table(head, tuple(rows), figures=0) if rows else None


def of_iterations(result: Result) -> Table:
    """Each iteration: samples, failures, s, effective sample size, errors."""
    head = ("iteration", "samples", "failed", "s", "s / states", "effective part", "ε_{GL} [%]", "ε of the most probable [%]")
    rows = []
    for iteration in result.iterations:
        found = (iteration.s, iteration.s_per_state, iteration.effective_sample_size, iteration.gl_error, iteration.error)
        rows.append((str(iteration.index), str(len(iteration.samples)), str(iteration.failed.sum()), *(numbers.value(each, 3) for each in found)))
    return Table(head, tuple(rows), figures=0)


def of_failures(result: Result) -> Table | None:
    """Failures by experiment and kind; None without."""
    kinds = failure_kinds(result)
    rows = tuple((each.experiment, each.kind, str(each.number), each.example) for each in kinds)
    return Table(("experiment", "kind", "evaluations", "for example"), rows, figures=4) if rows else None


def of_experiments(result: Result) -> Table:
    """What was compared with what."""
    rows = [(experiment.name, _model(experiment), _observables(experiment), " ".join(experiment.reference.notes)) for experiment in result.experiments]
    head = ("experiment", "model", "observables, and their shares of the variance", "notes on the reference")
    if not any(row[-1] for row in rows):
        head, rows = head[:-1], [row[:-1] for row in rows]
    return Table(head, tuple(rows), figures=len(head))


def of_provenance(result: Result) -> Table:
    """What the result was computed with."""
    calibration = result.calibration
    used = calibration.new_filter()
    settings = {
        "alpha": f"{used.alpha:g}",
        "samples per iteration": str(used.samples_per_iteration),
        "effective sample size": f"{used.effective_sample_size:g}",
        "scale": used.scale,
        "covariance": used.covariance,
    }
    stops = {name.replace("_", " "): "off" if limit is False else f"{limit:g}" for name, limit in asdict(result.stop).items()}
    rows = [
        ("calibration begun", _moment(result.started)),
        ("report written", _moment(datetime.now(timezone.utc).isoformat())),
        ("method", calibration.method),
        ("settings", _listed(settings)),
        ("criteria of stopping", _listed(stops)),
        ("seed", str(calibration.seed)),
        *result.provenance.items(),
    ]
    return Table(("", ""), tuple(rows), figures=2)


def origin(result: Result) -> str:
    """When and by what the calibration was begun, in a sentence."""
    return f"Calibrated with graincal {result.provenance['graincal']}, begun {_moment(result.started)}."


def _model(experiment: Experiment) -> str:
    model = experiment.model
    if isinstance(model, StressPathTest):
        at = f" at {numbers.pressure(model.confining_pressure)}" if model.confining_pressure is not None else ""
        return (
            f"{model.title}{at}, {numbers.count(model.packing.count, 'particle')} "
            f"({model.packing.name}), void ratio {model.packing.void_ratio:.3f}, density scaling {model.density_scaling:g}"
            + ("" if model.law == "linear" else f", contact law {model.law}")
            + ("" if model.precision == PRECISIONS[0] else f", precision {model.precision}")
            + "".join(f", {name.replace('_', ' ')} {value}" for name, value in model.economies.items())
            + "".join(f", {name} = {value:g} fixed" for name, value in model.fixed.items())
        )
    function = getattr(model, "function", None) or getattr(model, "name", None) or type(model).__name__
    return f"Python function {function if isinstance(function, str) else getattr(function, '__qualname__', function)}"


def _observables(experiment: Experiment) -> str:
    reference = experiment.reference
    shares = ", ".join(f"{quantity(name).label} {share:g}" for name, share in reference.variance_shares.items())
    control = quantity(reference.control_name)
    span = numbers.between(reference.control[0] * control.scale, reference.control[-1] * control.scale)
    return f"{shares}; {numbers.count(len(reference.control), 'state')}, {control.label} {span} {control.unit}".strip()


def _listed(values: dict[str, str]) -> str:
    return ", ".join(f"{name} {value}" for name, value in values.items())


def _moment(text: str) -> str:
    return datetime.fromisoformat(text).astimezone(timezone.utc).strftime("%Y-%m-%d %H:%M UTC")
