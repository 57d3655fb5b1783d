"""Can volumetric strain be left out? (section 4.6: Figures 19 and 20)"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from graincal.campaign.prediction import draw
from graincal.data import Response
from graincal.notation.quantities import quantity
from graincal.report.drawing import Figure
from graincal.studies.common import at_truth, on_synthetic, on_synthetic_by_posterior, proof, runs_at
from graincal.studies.curves import difference, over_strain
from graincal.studies.found import STRAIN, STRESS, Fit, at, fits, floor, mean_run, rows
from graincal.studies.records import Conclusion, Findings, Row, Table, Values, at_most, smaller
from graincal.studies.settings import BOTH, POSTERIOR, Setup
from graincal.studies.study import Case, Done, Study

PRINTED = {"stress and strain": {STRESS: 1.06, STRAIN: 1.20}, "stress only": {STRESS: 1.84, STRAIN: 19.67}}
RECORDED = ("volumetric_strain",)
SEEDS, DRAWS = 5, 30
STRAINS = np.linspace(0, 0.2, 51)
WIDTH = "width of the 90 % band [%]"


class StressOnly(Study):
    name = "stress-only"
    title = "Calibration on the stress ratio alone"
    where = "section 4.6, Figures 19 and 20"
    question = "Volumetric strain is recorded and not conditioned on. How well is it predicted, and the fabric?"

    def cases(self, setup: Setup, done: Done) -> Sequence[Case]:
        return [at_truth(setup), proof(setup), *self._alone(setup), *self._posteriors(setup, done).values(), *self._bands(setup, done).values()]

    def _alone(self, setup: Setup) -> list[Case]:
        return [on_synthetic(setup, "mid", 80, range(1, max(SEEDS, setup.seeds) + 1 if setup.seeds > 1 else 2), 8, recorded=RECORDED)]

    def _posteriors(self, setup: Setup, done: Done) -> dict[str, Case]:
        """By the method "posterior", one seed each."""
        return {"stress and strain": on_synthetic_by_posterior(setup, done, "mid", [1]), "stress only": on_synthetic_by_posterior(setup, done, "mid", [1], recorded=RECORDED)}

    def _bands(self, setup: Setup, done: Done) -> dict[str, Case]:
        """Runs at draws from the posteriors: what they predict for volumetric strain, whether they were conditioned on it or not."""
        return {
            name: Case(f"runs at draws of {name}", missing=case.missing)
            if case.missing
            else runs_at(setup, f"runs at draws of the posterior of {name}", f"runs-at-draws-{name.replace(' ', '-')}", lambda case=case: draw(done.results(case)[0].posterior, DRAWS, seed=1).theta, count=DRAWS, times=1)
            for name, case in self._posteriors(setup, done).items()
        }

    def findings(self, setup: Setup, done: Done) -> Findings:
        truth = at(done.repeats(at_truth(setup)), STRAINS)
        scatter = floor(truth, STRAINS, BOTH)
        found = {"stress and strain": fits(done.results(proof(setup))), "stress only": fits(result for case in self._alone(setup) for result in done.results(case))}
        by_posterior = {name: fits(done.results(case)) for name, case in self._posteriors(setup, done).items()}
        widths = {name: _width([run for many in done.runs(case) for run in many]) for name, case in self._bands(setup, done).items()}
        lines = []
        for name, printed in PRINTED.items():
            lines += rows(name, printed, found[name], scatter, (STRESS, STRAIN))
            lines += rows(name, printed, by_posterior[name], scatter, (STRESS, STRAIN), POSTERIOR)
            lines.append(Row(name, WIDTH, None, widths[name], None, POSTERIOR))
        table = Table("stress-only", "Errors with and without volumetric strain", tuple(lines), (f"The band is that of volumetric strain over runs at {DRAWS} draws from the posterior, the mean over the test.",))
        reference = None if proof(setup).missing else setup.synthetic()
        return Findings((table,), _figures(found, truth, reference), _conclusions(found, widths, scatter))


def _width(runs: Sequence[Response]) -> tuple[float, ...]:
    """The mean width of the 90 % interval of volumetric strain over the test, percent of strain; nothing without runs."""
    met = at(runs, STRAINS)
    if len(met) < 2:
        return ()
    low, high = np.quantile([run.values["volumetric_strain"] for run in met], [0.05, 0.95], axis=0)
    return (100 * float(np.mean(high - low)),)


def _figures(found: dict[str, list[Fit]], truth: Sequence[Response], reference) -> dict[int, Figure]:
    curves = {name: many[0].response for name, many in found.items() if many}
    if not curves:
        return {}
    figures = {19: over_strain("figure-19", "Calibrated on stress and strain, and on the stress ratio alone", "The first seed of each. Volumetric strain is predicted by the second, not fitted.", curves, reference, dots="synthetic reference")}
    if truth:
        exact, met = mean_run(truth), {name: at([run], STRAINS)[0] for name, run in curves.items()}
        panels = tuple(difference(quantity(name).title, {label: run.values[name] - exact.values[name] for label, run in met.items()}, STRAINS, name) for name in ("coordination_number", "a_c"))
        figures[20] = Figure("figure-20", "Differences of the fabric to that of the exact parameters", "The first seed of each.", panels, columns=2)
    return figures


def _conclusions(found: dict[str, list[Fit]], widths: dict[str, tuple[float, ...]], scatter: dict[str, float]) -> tuple[Conclusion, ...]:
    strain = {name: Values.of(f"the error of volumetric strain with {name}", [each.errors[STRAIN] for each in many], scatter.get(STRAIN)) for name, many in found.items()}
    stress = Values.of("the error of the stress ratio with stress only", [each.errors[STRESS] for each in found["stress only"]], scatter.get(STRESS))
    both, alone = (widths[name] for name in PRINTED)
    wider = Values.of("the band of volumetric strain without it, in widths of the band with it,", [other / one for one, other in zip(both, alone)], unit=" times")
    claims = {
        "The stress ratio alone can be fitted: its error is at most 2 %.": at_most(stress, 2.0),
        "Volumetric strain that is not conditioned on is predicted worse.": smaller(strain["stress and strain"], strain["stress only"]),
        "(Not in the paper) The posterior says so: its band of volumetric strain is at least three times as wide.": smaller(Values("3", (3.0,), unit=""), wider),
    }
    return tuple(Conclusion(claim, judgement) for claim, judgement in claims.items())
