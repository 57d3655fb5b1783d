"""Does a fit to curves give the right structure? (section 4.4: Tables 11 and 12, Figure 15)"""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np

from graincal.data import Response
from graincal.drawing.figure import Figure
from graincal.notation.quantities import quantity
from graincal.studies.common import at_truth, proof_by_posterior, runs_at
from graincal.studies.curves import difference
from graincal.studies.floors import FABRIC, STRAIN, STRAINS, STRESS, at, fabric_errors, floor_of, mean_run
from graincal.studies.found import Fit, fits
from graincal.studies.judging import NUMBER, Values, all_of, correlation_at_least, smaller
from graincal.studies.range_alpha import SETTINGS, cases_by_setting
from graincal.studies.records import Conclusion, Findings, Row, Table, conclusions
from graincal.studies.settings import ITERATIVE, POSTERIOR, Setup
from graincal.studies.study import Case, Done, Study

PRINTED = {
    "wide, α = 5": (5.16, 7.33, 4.13, 15.32),
    "mid, α = 10": (0.43, 2.02, 1.31, 2.15),
    "extra wide, α = 20": (2.02, 6.01, 3.63, 3.27),
    "extra wide, α = 30": (0.49, 1.83, 1.50, 2.99),
}
"""Table 11, in the order of FABRIC."""

POOR, GOOD = ("wide, α = 5", "extra wide, α = 20"), ("mid, α = 10", "extra wide, α = 30")

CORRELATIONS = {STRESS: (0.82, 0.79, 0.95, 0.86), STRAIN: (0.69, 0.86, 0.73, 0.44)}
"""Table 12. They do not follow from the four rows of Table 11; which calibrations went in is not said."""

FEWEST = 8
"""Calibrations, of fewer than which no correlation is given."""

Pair = tuple[Fit, dict[str, float]]
"""A calibration, and the errors of the fabric of its run."""


class Fabric(Study):
    name = "fabric"
    title = "The structure behind the curves"
    where = "section 4.4, Tables 11 and 12, Figure 15"
    question = "Parameters that fit the curves: do they give the coordination number and the fabric of the true ones too?"

    def cases(self, setup: Setup, done: Done) -> Sequence[Case]:
        return [at_truth(setup), *_at_printed(setup).values(), *cases_by_setting(setup).values(), proof_by_posterior(setup, done)]

    def findings(self, setup: Setup, done: Done) -> Findings:
        runs = at(done.repeats(at_truth(setup)), STRAINS)
        truth = mean_run(runs) if runs else None
        single = {name: floor_of(runs, name) for name in FABRIC}
        repeated = {name: at(done.repeats(case), STRAINS) for name, case in _at_printed(setup).items()}
        means = {name: mean_run(many) for name, many in repeated.items() if many}
        apart = {name: fabric_errors(mean, truth) for name, mean in means.items()} if truth else {}
        # A mean of several runs scatters less than one of them.
        scatter = {name: None if value is None else value / np.sqrt(len(runs)) for name, value in single.items()}
        ours = {setting.name: _pairs(fits(done.results(case)), truth) for setting, case in cases_by_setting(setup).items()}
        by_posterior = _pairs(fits(done.results(proof_by_posterior(setup, done))), truth)
        missing = {name: case.missing for name, case in _at_printed(setup).items()}
        every = [pair for many in ours.values() for pair in many]
        tables = (_table_11(apart, ours, by_posterior, single, scatter, missing), _table_12(every))
        figures = {15: _figure(means, truth)} if truth and means else {}
        return Findings(tables, figures, _conclusions(apart, scatter, every), _HOW)


_HOW = (
    "The rows at the paper's parameters are means of repeated runs, compared with the mean of runs at the exact parameters.",
    'Those of our own calibrations are single runs, and means of several by "posterior".',
)


def _at_printed(setup: Setup) -> dict[str, Case]:
    """Runs at the parameters that the paper printed of four calibrations."""
    chosen = {setting.name: setting for setting in SETTINGS if setting.name in PRINTED}
    folder = {name: f"runs-at-{name.replace(' ', '-').replace(',', '').replace('-α-=', '-alpha')}" for name in PRINTED}
    return {name: runs_at(setup, f"the paper's parameters of {name}", folder[name], [chosen[name].printed[:5]]) for name in PRINTED}


def _pairs(found: Sequence[Fit], truth: Response | None) -> list[Pair]:
    """Without those whose run does not reach the last strain."""
    if truth is None:
        return []
    return [(fit, fabric_errors(met, truth)) for fit in found for met in at([fit.response], STRAINS)]


def _table_11(
    apart: Mapping[str, dict[str, float]],
    ours: Mapping[str, Sequence[Pair]],
    by_posterior: Sequence[Pair],
    single: Mapping[str, float | None],
    scatter: Mapping[str, float | None],
    missing: Mapping[str, str],
) -> Table:
    lines = []
    for setting, printed in PRINTED.items():
        errors = apart.get(setting, {})
        for name, value in zip(FABRIC, printed):
            lines.append(
                Row(
                    f"{setting}, the paper's parameters",
                    FABRIC[name],
                    value,
                    (errors[name],) if errors else (),
                    scatter[name],
                    missing=missing[setting],
                )
            )
    for setting, many in (*ours.items(), ("mid", by_posterior)):
        method = POSTERIOR if setting == "mid" else ITERATIVE
        if many:
            lines += [Row(f"{setting}, our parameters", FABRIC[name], None, tuple(errors[name] for _, errors in many), single[name], method) for name in FABRIC]
    return Table(11, "Errors of the fabric", tuple(lines))


def _table_12(every: Sequence[Pair]) -> Table:
    correlations = _correlations(every)
    lines = [
        Row(f"{observable} and", FABRIC[name], value, (correlations[observable, name],) if correlations else ())
        for observable, printed in CORRELATIONS.items()
        for name, value in zip(FABRIC, printed)
    ]
    notes = (
        f"Ours are over {len(every)} calibrations, all seeds of the study of ranges; for fewer than {FEWEST} there are none.",
        "The paper's do not follow from the four rows of its Table 11; which calibrations went in is not said.",
    )
    return Table(12, "Correlations between errors of the curves and of the fabric", tuple(lines), notes)


def _correlations(every: Sequence[Pair]) -> dict[tuple[str, str], float]:
    """Pearson's coefficients of an error of a curve with that of a quantity of the fabric; none for few calibrations."""
    if len(every) < FEWEST:
        return {}
    of_curves = {observable: [fit.errors[observable] for fit, _ in every] for observable in CORRELATIONS}
    of_fabric = {name: [errors[name] for _, errors in every] for name in FABRIC}
    return {(observable, name): float(np.corrcoef(of_curves[observable], of_fabric[name])[0, 1]) for observable in CORRELATIONS for name in FABRIC}


def _figure(means: Mapping[str, Response], truth: Response) -> Figure:
    differences = {name: {label: mean.values[name] - truth.values[name] for label, mean in means.items()} for name in FABRIC}
    panels = tuple(difference(quantity(name).title, curves, STRAINS, name) for name, curves in differences.items())
    caption = "Means of repeated runs at the paper's parameters of four calibrations, less the mean at the exact parameters."
    return Figure("figure-15", "Differences of the fabric to that of the exact parameters", caption, panels, columns=2)


def _conclusions(apart: Mapping[str, dict[str, float]], scatter: Mapping[str, float | None], every: Sequence[Pair]) -> tuple[Conclusion, ...]:
    shown = {name: label.removesuffix(" [%]") for name, label in FABRIC.items()}

    def error(setting: str, name: str) -> Values:
        return Values.of_finite(f"{shown[name]} of {setting}", [apart[setting][name]] if setting in apart else [], scatter[name], of=NUMBER)

    worst = POOR[0]
    largest = [smaller(error(other, name), error(worst, name)) for name in FABRIC for other in PRINTED if other != worst]
    by_grade = [smaller(error(good, name), error(poor, name)) for name in ("coordination_number", "a_c", "a_n") for poor in POOR for good in GOOD]
    correlations = _correlations(every)
    with_stress = [
        correlation_at_least(f"the correlation of the errors of stress ratio and {shown[name]}", correlations.get((STRESS, name), np.nan), len(every), 0.7)
        for name in FABRIC
    ]
    return conclusions(
        {
            "The worst fit of the wide range, with α = 5, has the largest error of each quantity of the fabric.": all_of(largest),
            "Sub-optimal parameters give a worse coordination number, a_{c} and a_{n} than optimal ones.": all_of(by_grade),
            "Errors of the stress ratio go with errors of all quantities of the fabric: correlations are at least 0.7.": all_of(with_stress),
        }
    )
