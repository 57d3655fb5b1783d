"""Can volumetric strain be left out? (section 4.6: Figures 19 and 20)"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from functools import partial

import numpy as np
from numpy.typing import NDArray

from graincal.campaign.found.prediction import draw
from graincal.data import InputError, Reference, Response
from graincal.drawing.figure import Figure
from graincal.notation.quantities import quantity
from graincal.studies.bands import ratio_of_widths, width
from graincal.studies.common import at_truth, floor_on_synthetic, needs_synthetic, on_synthetic, on_synthetic_by_posterior, proof, runs_after
from graincal.studies.curves import difference, over_strain
from graincal.studies.floors import FABRIC, STRAIN, STRAINS, STRESS, at, fabric_errors, floor_of, mean_run
from graincal.studies.found import ITERATIONS, Fit, cut, fit_in, fits, rows, values
from graincal.studies.judging import Values, all_of, at_least, at_most, smaller
from graincal.studies.records import Conclusion, Findings, Row, Table, conclusions
from graincal.studies.settings import ITERATIVE, POSTERIOR, Setup
from graincal.studies.study import Case, Done, Study

BOTH_OF, ALONE = "stress and strain", "stress only"
PRINTED = {BOTH_OF: {STRESS: 1.06, STRAIN: 1.20, ITERATIONS: 10}, ALONE: {STRESS: 1.84, STRAIN: 19.67, ITERATIONS: 7}}
AT = 7
"""The iteration of which the paper prints its result with stress only."""

RECORDED = ("volumetric_strain",)
SEEDS, DRAWS = 5, 30
WIDTH = "width of the 90 % band [%]"
SHOWN = ("coordination_number", "a_c")
"""The quantities of the fabric in Figure 20."""


class StressOnly(Study):
    name = "stress-only"
    title = "Calibration on the stress ratio alone"
    where = "section 4.6, Figures 19 and 20"
    question = "Volumetric strain is recorded and not conditioned on. How well is it predicted, and the fabric?"

    def cases(self, setup: Setup, done: Done) -> Sequence[Case]:
        bands = [case for many in _bands(setup, done).values() for case in many]
        return [at_truth(setup), proof(setup), _alone(setup), *_posteriors(setup, done).values(), *bands]

    def findings(self, setup: Setup, done: Done) -> Findings:
        truth, missing = at(done.repeats(at_truth(setup)), STRAINS), needs_synthetic(setup)
        scatter = floor_on_synthetic(setup, done)
        results = {BOTH_OF: done.results(proof(setup)), ALONE: done.results(_alone(setup))}
        found = {name: fits(many) for name, many in results.items()}
        at_seven = [fit for result in results[ALONE] if len(result.iterations) > AT and (fit := fit_in(result, result.iterations[AT]))]
        by_posterior = {name: fits(done.results(case)) for name, case in _posteriors(setup, done).items()}
        runs = {name: [at(done.all_runs(case), STRAINS) for case in cases] for name, cases in _bands(setup, done).items()}
        fabric = {name: _fabric(many, truth) for name, many in found.items()}
        floors = {name: floor_of(truth, name) for name in FABRIC}
        lines = [*_rows(found, at_seven, scatter, missing), *_rows_by_posterior(by_posterior, runs, scatter), *_fabric_rows(fabric, floors)]
        notes = (
            f"The band is that of volumetric strain over runs at {DRAWS} draws from the posterior, the mean over the test.",
            f"The paper prints the result of iteration {AT} with stress only, and does not say what ended it there.",
        )
        table = Table("stress-only", "Errors with and without volumetric strain", tuple(lines), notes)
        figures = _figures(found, truth, None if missing else setup.synthetic())
        return Findings((table,), figures, _conclusions(found, fabric, runs, scatter, floors))


def _alone(setup: Setup) -> Case:
    seeds = range(1, max(SEEDS, setup.seeds) + 1 if setup.seeds > 1 else 2)
    return on_synthetic(setup, "mid", 80, seeds, 8, recorded=RECORDED)


def _posteriors(setup: Setup, done: Done) -> dict[str, Case]:
    """By the method "posterior". With stress only there is one seed, for its runs to come are the longest of the study."""
    return {
        BOTH_OF: on_synthetic_by_posterior(setup, done, "mid", setup.short),
        ALONE: on_synthetic_by_posterior(setup, done, "mid", [1], recorded=RECORDED),
    }


def _bands(setup: Setup, done: Done) -> dict[str, list[Case]]:
    """Runs at draws from the posterior of each seed: what it predicts for volumetric strain, whether that was conditioned on or not."""
    return {name: _bands_of(setup, done, name, case) for name, case in _posteriors(setup, done).items()}


def _bands_of(setup: Setup, done: Done, name: str, posterior: Case) -> list[Case]:
    if posterior.missing:
        return [Case(f"runs at draws of {name}", missing=posterior.missing)]
    cases = []
    for seed, work in enumerate(posterior.work, 1):
        of_seed = Case(posterior.setting, (work,))
        folder = f"runs-at-draws-{name.replace(' ', '-')}" + (f"-seed-{seed}" if seed > 1 else "")
        cases.append(runs_after(setup, f"runs at draws of the posterior of {name}, seed {seed}", folder, partial(_draws, done, of_seed), DRAWS, of_seed))
    return cases


def _draws(done: Done, posterior: Case) -> NDArray[np.float64]:
    """Draws (K, n) from the posterior of a case of one calibration. Raises InputError where it has none."""
    found = [result.posterior for result in done.results(posterior) if result.posterior is not None]
    if not found:
        raise InputError(f"{posterior.setting}: it has no posterior to draw from.")
    return draw(found[0], DRAWS, seed=1).theta


def _fabric(found: Sequence[Fit], truth: Sequence[Response]) -> list[dict[str, float]]:
    """The errors of the fabric of each calibration whose run reaches the last strain."""
    if not truth:
        return []
    return [fabric_errors(met, mean_run(truth)) for fit in found for met in at([fit.response], STRAINS)]


def _rows(found: Mapping[str, Sequence[Fit]], at_seven: Sequence[Fit], scatter: Mapping[str, float], missing: str) -> list[Row]:
    lines = rows(BOTH_OF, PRINTED[BOTH_OF], found[BOTH_OF], scatter, (STRESS, STRAIN, ITERATIONS), missing=missing)
    lines += rows(f"{ALONE}, iteration {AT}", PRINTED[ALONE], at_seven, scatter, (STRESS, STRAIN, ITERATIONS), missing=missing)
    return lines + rows(f"{ALONE}, at the end", {}, found[ALONE], scatter, (STRESS, STRAIN, ITERATIONS), missing=missing)


def _rows_by_posterior(by_posterior: Mapping[str, Sequence[Fit]], runs: Mapping[str, Sequence[Sequence[Response]]], scatter: Mapping[str, float]) -> list[Row]:
    lines = []
    for name, setting in ((BOTH_OF, BOTH_OF), (ALONE, f"{ALONE}, at the end")):
        lines += rows(setting, PRINTED[name] if name == BOTH_OF else {}, by_posterior[name], scatter, (STRESS, STRAIN), POSTERIOR)
        lines.append(Row(setting, WIDTH, None, tuple(width(each) for each in runs[name]), None, POSTERIOR))
    return lines


def _fabric_rows(fabric: Mapping[str, Sequence[Mapping[str, float]]], floors: Mapping[str, float | None]) -> list[Row]:
    return [
        Row(f"{name}, fabric", FABRIC[column], None, tuple(each[column] for each in fabric[name]), floors[column], ITERATIVE)
        for name in (BOTH_OF, ALONE)
        for column in FABRIC
    ]


def _figures(found: Mapping[str, Sequence[Fit]], truth: Sequence[Response], reference: Reference | None) -> dict[int, Figure]:
    curves = {name: many[0].response for name, many in found.items() if many}
    if not curves or reference is None:
        return {}
    caption = "The first seed of each. Volumetric strain is predicted by the second, not fitted."
    title = "Calibrated on stress and strain, and on the stress ratio alone"
    figures = {19: over_strain("figure-19", title, caption, curves, {"synthetic reference": reference})}
    met = {name: reached[0] for name, run in curves.items() if (reached := at([run], STRAINS))}
    if truth and met:
        exact = mean_run(truth)
        differences = {name: {label: run.values[name] - exact.values[name] for label, run in met.items()} for name in SHOWN}
        panels = tuple(difference(quantity(name).title, each, STRAINS, name) for name, each in differences.items())
        figures[20] = Figure("figure-20", "Differences of the fabric to that of the exact parameters", "The first seed of each.", panels, columns=2)
    return figures


def _conclusions(
    found: Mapping[str, Sequence[Fit]],
    fabric: Mapping[str, Sequence[Mapping[str, float]]],
    runs: Mapping[str, Sequence[Sequence[Response]]],
    scatter: Mapping[str, float],
    floors: Mapping[str, float | None],
) -> tuple[Conclusion, ...]:
    strain = {name: values(f"the error of volumetric strain with {name}", many, STRAIN, scatter) for name, many in found.items()}
    stress = values("the error of the stress ratio with stress only", found[ALONE], STRESS, scatter)

    def of_fabric(name: str, column: str) -> Values:
        how = f" ({said})" if (said := cut(found[name])) else ""
        return Values.of_finite(f"{FABRIC[column].removesuffix(' [%]')} with {name}{how}", [each[column] for each in fabric[name]], floors[column])

    worse = [smaller(of_fabric(BOTH_OF, column), of_fabric(ALONE, column)) for column in SHOWN]
    claims = {
        "The stress ratio alone can be fitted: its error is at most 2 %.": at_most(stress, 2.0),
        "Volumetric strain that is not conditioned on is predicted worse.": smaller(strain[BOTH_OF], strain[ALONE]),
        "The coordination number and a_{c} are further from the true ones with stress only.": all_of(worse),
    }
    wider = ratio_of_widths("the band of volumetric strain without it, as a multiple of the band with it,", runs[ALONE], runs[BOTH_OF], BOTH_OF)
    said = {"The posterior shows what is not known: its band of volumetric strain is at least three times as wide.": at_least(wider, 3.0)}
    return (*conclusions(claims), *conclusions(said, of_paper=False))
