"""Does what was calibrated at one pressure predict others? (section 4.3: Table 10, Figure 14)"""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np

from graincal.data import Response
from graincal.inference.errors import curve_error
from graincal.studies import paper
from graincal.studies.common import proof, runs_at
from graincal.studies.curves import over_strain
from graincal.studies.found import ERROR, STRAIN, STRESS, at, fits, floor, mean_run
from graincal.studies.records import Conclusion, Findings, Row, Table, Values, all_of, at_most
from graincal.studies.settings import BOTH, Setup
from graincal.studies.study import Case, Done, Study

PRINTED = {0.2e6: {STRESS: 2.68, STRAIN: 2.60, ERROR: 2.64}, 1.0e6: {STRESS: 1.11, STRAIN: 2.26, ERROR: 1.69}}
STRAINS = np.linspace(0, 0.2, 51)


class Pressures(Study):
    name = "pressures"
    title = "Other confining pressures"
    where = "section 4.3, Table 10, Figure 14"
    question = "Do parameters that were calibrated at 0.5 MPa predict tests at 0.2 and 1.0 MPa?"

    def cases(self, setup: Setup, done: Done) -> Sequence[Case]:
        return [proof(setup), *(case for pressure in PRINTED for case in self._at(setup, done, pressure).values())]

    def _at(self, setup: Setup, done: Done, pressure: float) -> dict[str, Case]:
        """The runs at one pressure, by whose parameters they are."""
        calibrated, named = proof(setup), f"at {pressure / 1e6:g} MPa"
        theta = lambda: [each.theta for each in fits(done.results(calibrated))]  # noqa: E731
        runs = {
            "truth": runs_at(setup, f"the exact parameters {named}", f"runs-at-truth-{pressure / 1e6:g}MPa", [paper.TRUTH], pressure=pressure),
            "paper": runs_at(setup, f"the paper's calibrated parameters {named}", f"runs-at-calibrated-{pressure / 1e6:g}MPa", [paper.CALIBRATED], pressure=pressure),
        }
        own = Case(f"our calibrated parameters {named}", missing=calibrated.missing)
        if not calibrated.missing:
            own = runs_at(setup, own.setting, f"runs-at-own-{pressure / 1e6:g}MPa-{len(setup.short)}", theta, count=len(setup.short), times=1, pressure=pressure)
        return runs | {"own": own}

    def findings(self, setup: Setup, done: Done) -> Findings:
        lines, curves, judged = [], {}, []
        for pressure, printed in PRINTED.items():
            cases = self._at(setup, done, pressure)
            truth, by_paper = at(done.repeats(cases["truth"]), STRAINS), at(done.repeats(cases["paper"]), STRAINS)
            own = at([run for many in done.runs(cases["own"]) for run in many], STRAINS)
            scatter, setting = floor(truth, STRAINS, BOTH), f"{pressure / 1e6:g} MPa"
            apart = _errors(by_paper, truth)
            lines += [Row(f"{setting}, the paper's parameters", name, printed[name], apart[name], scatter.get(name)) for name in printed]
            lines += [Row(f"{setting}, our parameters", name, None, values, scatter.get(name)) for name, values in _errors(own, truth).items()]
            judged.append(at_most(Values.of(f"ε at {setting} by the paper's parameters", apart[ERROR], scatter.get(ERROR)), printed[ERROR] + scatter.get(ERROR, 0)))
            curves |= {f"{who}, {setting}": mean_run(runs) for who, runs in (("exact parameters", truth), ("the paper's calibrated", by_paper)) if runs}
        table = Table(10, "Prediction errors at pressures that nothing was calibrated at", tuple(lines), ("Each run is compared with a run at the exact parameters at the same pressure.",))
        figures = {14: over_strain("figure-14", "Predictions at other confining pressures", "Means of repeated runs.", curves)} if curves else {}
        return Findings((table,), figures, (Conclusion("Parameters that were calibrated at one pressure predict the test at others: errors are as small as the paper's.", all_of(judged)),))


def _errors(runs: Sequence[Response], truth: Sequence[Response]) -> Mapping[str, tuple[float, ...]]:
    """Eq. 5 and 6 of each run against the run at the truth of its number."""
    by_observable = {quantity: tuple(curve_error(run.values[name], truth[number % len(truth)].values[name]) for number, run in enumerate(runs if truth else ())) for name, quantity in (("stress_ratio", STRESS), ("volumetric_strain", STRAIN))}
    return by_observable | {ERROR: tuple(np.mean(list(by_observable.values()), axis=0)) if runs and truth else ()}
