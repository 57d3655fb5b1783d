"""The report's tables: rows of text in markup."""

from __future__ import annotations

import shlex
from collections.abc import Sequence
from dataclasses import asdict, dataclass
from datetime import UTC, datetime

import numpy as np

from graincal.campaign import Calibration, Experiment
from graincal.campaign.asked.calibration import CRITERIA
from graincal.campaign.asked.errors import describe_errors
from graincal.campaign.asked.prior import beside_ranges
from graincal.campaign.found.emulated import Emulated
from graincal.campaign.found.findings import Finding
from graincal.campaign.found.record import Record
from graincal.campaign.found.trust import has_settled
from graincal.inference import PosteriorFilter
from graincal.inference.posterior.first_look import FirstLook
from graincal.inference.sampling.groups import find_groups
from graincal.inference.sampling.posterior import PROBABILITY
from graincal.models import ByHandModel, CommandModel, StressPathTest
from graincal.models.contact_laws import DEFAULT_LAW
from graincal.notation import numbers
from graincal.notation.quantities import parameters, quantity
from graincal.report.run_times import failure_kinds


@dataclass(frozen=True)
class Table:
    """A table: its head and its rows, of equal length. Columns from `figures` on hold figures."""

    head: tuple[str, ...]
    rows: tuple[tuple[str, ...], ...]
    figures: int = 1


def of_parameters(result: Record, findings: tuple[Finding, ...]) -> Table:
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


def of_prior(result: Record) -> list[str]:
    """Sentences on the prior beside its ranges; mostly none."""
    return beside_ranges(result.space)


def of_groups(result: Record) -> Table | None:
    """The separate groups that carry the weight: their shares and centres; None for a single one."""
    groups = find_groups(result.space, result.posterior) if result.posterior else ()
    rows = [(f"{100 * group.share:.0f} %", *(numbers.value(value) for value in group.centre)) for group in groups]
    head = ("share of the weight", *(shown.axis for shown in parameters(result.space)))
    return Table(head, tuple(rows), figures=0) if rows else None


def of_iterations(result: Record) -> Table:
    """Each iteration: samples, failures, s, effective sample size, errors."""
    head = ("iteration", "samples", "failed", "s", "s / states", "effective part", "ε_{GL} [%]", "ε of the most probable [%]")
    rows = []
    for iteration in result.iterations:
        found = (iteration.s, iteration.s_per_state, iteration.effective_sample_size, iteration.gl_error, iteration.error)
        rows.append((str(iteration.index), str(len(iteration.samples)), str(iteration.failed.sum()), *(numbers.value(each, 3) for each in found)))
    return Table(head, tuple(rows), figures=0)


def of_batches(result: Record) -> Table:
    """Each batch of the method "posterior": samples, failures, those that were stopped where some were, and what was learnt."""
    some = result.stopped.any()
    head = (
        "batch",
        "runs",
        "failed",
        *(["stopped early"] if some else []),
        "doubt [sd]",
        "shift [sd]",
        "held-out error [%]",
        "coverage [%]",
        "log evidence",
        "effective runs",
        "best ε [%]",
    )
    rows = []
    for iteration, learnt, best in zip(result.iterations, result.learnt, result.best_errors):
        figures = [
            numbers.value(learnt.doubt, 2),
            numbers.value(learnt.posterior_shift, 2),
            numbers.value(100 * learnt.held_out_error, 2),
            numbers.value(100 * learnt.coverage, 3),
        ]
        figures += [f"{learnt.log_evidence:.2f}" if np.isfinite(learnt.log_evidence) else "–", numbers.value(learnt.effective_runs, 2), numbers.value(best, 3)]
        counts = [len(iteration.samples), iteration.failed.sum(), *([0 if iteration.stopped is None else iteration.stopped.sum()] if some else [])]
        rows.append((str(iteration.index), *map(str, counts), *figures))
    return Table(head, tuple(rows), figures=0)


def of_identified(emulated: Emulated, verdicts: Sequence[str]) -> Table:
    """Each parameter: range, truth where one is known, answer, values of runs that fit about as well, interval, moments, strongest correlation and verdict."""
    result, posterior, space, fits = emulated.result, emulated.posterior, emulated.result.space, emulated.fits
    head = ("parameter", "range", *(["truth"] if result.truth else []), "answer", "runs that fit")
    head += (f"{100 * PROBABILITY:.0f} % interval{'' if has_settled(result) else ' so far'}",)
    head += ("mean ± sd", "sd / prior's")
    labels, mean, std = [shown.label for shown in parameters(space)], posterior.mean(), posterior.std()
    interval, correlation = posterior.interval(PROBABILITY), np.nan_to_num(posterior.correlation())
    np.fill_diagonal(correlation, 0)
    rows = []
    for k, shown in enumerate(parameters(space)):
        row = [shown.axis, f"{numbers.short(space.low[k])} to {numbers.short(space.high[k])}"]
        if result.truth:
            row.append(numbers.short(result.truth[space.names[k]]) if space.names[k] in result.truth else "–")
        strongest = int(np.argmax(np.abs(correlation[k])))
        row += [numbers.value(emulated.answer.theta[k]), numbers.between(fits.low[k], fits.high[k]), numbers.between(*interval[:, k])]
        row += [numbers.estimate(mean[k], std[k]), f"{emulated.shrinkage[k]:.2f}"]
        row.append(f"{numbers.signed(correlation[k, strongest])} with {labels[strongest]}" if len(labels) > 1 else "–")
        rows.append((*row, verdicts[k]))
    return Table((*head, "strongest correlation", "verdict"), tuple(rows))


def of_informing(emulated: Emulated) -> Table | None:
    """Posterior over prior standard deviation of each parameter, with all observables and with each alone; None for a single one, or many."""
    result, alone = emulated.result, emulated.alone
    if not alone:
        return None
    several = len(result.experiments) > 1
    by = [(f"{result.experiments[number].name}: " if several else "") + f"{quantity(name).label} alone" for number, name in alone]
    columns = (emulated.shrinkage, *alone.values())
    rows = tuple((shown.label, *(f"{column[k]:.2f}" for column in columns)) for k, shown in enumerate(parameters(result.space)))
    return Table(("sd / prior's by", "all", *by), rows)


def tells_more_alone(emulated: Emulated) -> bool:
    """Whether some observable alone leaves a parameter a smaller standard deviation than all together do, by a tenth at the least."""
    return any(np.any(alone < 0.9 * emulated.shrinkage) for alone in emulated.alone.values())


def of_terms(emulated: Emulated) -> Table | None:
    """Each parameter's interval, and what it would be without a discrepancy and if packings were alike, where these are allowed for; None where neither is."""
    others = {"without a discrepancy": emulated.without_discrepancy, "if packings were alike": emulated.without_packings}
    found = {f"{100 * PROBABILITY:.0f} % interval": emulated.posterior} | {words: other for words, other in others.items() if other}
    if len(found) == 1:
        return None
    intervals = [each.interval(PROBABILITY) for each in found.values()]
    rows = [(shown.axis, *(numbers.between(*interval[:, k]) for interval in intervals)) for k, shown in enumerate(parameters(emulated.result.space))]
    return Table(("parameter", *found), tuple(rows))


def of_modes(emulated: Emulated) -> Table | None:
    """The separate groups of values: their probability, centres, most probable values, and the least error of the runs in them; None for a single one."""
    shown = parameters(emulated.result.space)
    head = ("probability", *(f"{each.axis}: centre, most probable" for each in shown), "least ε of its runs [%]")
    rows = [
        (
            f"{100 * mode.share:.0f} %",
            *(f"{numbers.value(centre, 3)}, {numbers.value(best, 3)}" for centre, best in zip(mode.centre, mode.best)),
            numbers.value(mode.error, 3),
        )
        for mode in emulated.modes
    ]
    return Table(head, tuple(rows), figures=0) if rows else None


def of_failures(result: Record) -> Table | None:
    """Failures by experiment and kind; None without."""
    kinds = failure_kinds(result)
    rows = tuple((each.experiment, each.kind, str(each.number), each.example) for each in kinds)
    return Table(("experiment", "kind", "evaluations", "for example"), rows, figures=4) if rows else None


def of_experiments(result: Record) -> Table:
    """What was compared with what."""
    rows: list[tuple[str, ...]] = [
        (experiment.name, _model(experiment), _observables(experiment), " ".join(experiment.reference.notes)) for experiment in result.experiments
    ]
    head: tuple[str, ...] = ("experiment", "model", "observables, and their shares of the variance", "notes on the reference")
    if result.has_posterior:
        head = (*head[:-1], "errors", head[-1])
        errors = ["; ".join(describe_errors(experiment.reference)) for experiment in result.experiments]
        rows = [(*row[:-1], error, row[-1]) for row, error in zip(rows, errors)]
    if not any(row[-1] for row in rows):
        head, rows = head[:-1], [row[:-1] for row in rows]
    return Table(head, tuple(rows), figures=len(head))


def of_provenance(result: Record) -> Table:
    """What the result was computed with."""
    calibration = result.calibration
    settings = _settings(calibration)
    limits = {name: limit for name, limit in asdict(result.stop).items() if name in CRITERIA[calibration.method]}
    if result.has_posterior:
        used = calibration.blank_filter()
        limits["max_evaluations"] = isinstance(used, PosteriorFilter) and (used.most_evaluations or False)
    stops = {name.replace("_", " "): "off" if limit is False or limit is None else f"{limit:g}" for name, limit in limits.items()}
    rows = [
        ("calibration begun", _moment(result.started)),
        ("report written", _moment(datetime.now(UTC).isoformat())),
        ("method", calibration.method),
        ("settings", _listed(settings)),
        ("criteria of stopping", _listed(stops)),
        ("seed", str(calibration.seed)),
        *result.provenance.items(),
    ]
    return Table(("", ""), tuple(rows), figures=2)


def _first_look(calibration: Calibration, look: FirstLook) -> str:
    cheaper = [experiment.model for experiment in calibration.look.experiments] if calibration.look else []
    counts = {numbers.count(model.first_packing.count, "particle") for model in cheaper if isinstance(model, StressPathTest)}
    return f"{len(look.theta)} evaluations of a cheaper model" + (f" ({', '.join(sorted(counts))})" if counts else "")


def _settings(calibration: Calibration) -> dict[str, str]:
    used = calibration.blank_filter()
    if isinstance(used, PosteriorFilter):
        length = calibration.error_options["correlation_length"]
        return {
            **({"first look": _first_look(calibration, calibration.first_look)} if calibration.first_look else {}),
            "first batch": str(used.first_batch),
            "batch": "a quarter of the runs so far" if used.batch is None else str(used.batch),
            **({"ahead": str(used.ahead)} if used.ahead else {}),
            **({"early stop": "of runs that cannot matter"} if used.early_stop else {}),
            "correlation length of the errors": "any" if length is None else f"{length:g} of the curve",
            "discrepancy": _allowed(used),
        }
    return {
        "alpha": f"{used.alpha:g}",
        "samples per iteration": str(used.samples_per_iteration),
        "effective sample size": f"{used.effective_sample_size:g}",
        "scale": used.scale,
        "covariance": used.covariance,
    }


def origin(result: Record) -> str:
    """When and by what the calibration was begun, in a sentence."""
    return f"Calibrated with graincal {result.provenance['graincal']}, begun {_moment(result.started)}."


def _model(experiment: Experiment) -> str:
    model = experiment.model
    if isinstance(model, StressPathTest):
        at = f" at {numbers.pressure(model.confining_pressure)}" if model.confining_pressure is not None else ""
        return (
            f"{model.title}{at}, {numbers.count(model.first_packing.count, 'particle')} "
            f"({', '.join(packing.name for packing in model.packings)}), void ratio {model.first_packing.void_ratio:.3f}, {model.density_in_words}"
            + ("" if model.law == DEFAULT_LAW else f", contact law {model.law}")
            + "".join(f", {name.replace('_', ' ')} {value}" for name, value in model.economies.items())
            + "".join(f", {name} = {value:g} fixed" for name, value in model.fixed.items())
            + (f", {model.turns_in_words}" if model.turns_in_words else "")
        )
    if isinstance(model, ByHandModel):
        return "runs made by hand"
    if isinstance(model, CommandModel):
        return f"command: {shlex.join(model.command)}"
    function = getattr(model, "function", None) or getattr(model, "name", None) or type(model).__name__
    return f"Python function {function if isinstance(function, str) else getattr(function, '__qualname__', function)}"


def _observables(experiment: Experiment) -> str:
    reference = experiment.reference
    shares = ", ".join(f"{quantity(name).label} {share:g}" for name, share in reference.variance_shares.items())
    control = quantity(reference.control_name)
    beside = f"; not fitted: {', '.join(quantity(name).label for name in reference.recorded)}" if reference.recorded else ""
    span = numbers.between(reference.control[0] * control.scale, reference.control[-1] * control.scale)
    return f"{shares}{beside}; {numbers.count(len(reference.control), 'row')}, {control.label} {span} {control.unit}".strip()


def _listed(values: dict[str, str]) -> str:
    return ", ".join(f"{name} {value}" for name, value in values.items())


def _moment(text: str | None) -> str:
    assert text is not None, "a store says when it was begun"
    return datetime.fromisoformat(text).astimezone(UTC).strftime("%Y-%m-%d %H:%M UTC")


def _allowed(used: PosteriorFilter) -> str:
    """The discrepancies that are allowed for, as parts of the peaks."""
    sizes = sorted({float(size) for errors in used.errors for size in errors.discrepancies if size})
    return f"{100 * sizes[0]:g} to {100 * sizes[-1]:g} % of the peaks" if sizes else "none"
