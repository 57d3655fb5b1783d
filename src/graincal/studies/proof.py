"""Is a known truth found again? (section 4.1: Table 6, Figures 9 and 10)"""

from __future__ import annotations

from collections.abc import Sequence

from graincal.studies import paper
from graincal.studies.common import at_truth, on_synthetic_by_posterior, proof
from graincal.studies.curves import over_iterations, over_strain
from graincal.studies.found import ERROR, STRAIN, STRESS, fits, floor, parameter_labels, rows
from graincal.studies.records import Conclusion, Findings, Row, Table, Values, all_of, at_most, off
from graincal.studies.settings import BOTH, POSTERIOR, Setup
from graincal.studies.study import Case, Done, Study

PRINTED = dict(zip(paper.PARAMETERS, paper.CALIBRATED)) | {STRESS: 1.06, STRAIN: 1.20, ERROR: 1.13}
LAST_GL_ERROR = 1.88


class Proof(Study):
    name = "proof"
    title = "A known truth is found again"
    where = "section 4.1, Table 6, Figures 9 and 10"
    question = "A run at known parameters stands for the test. Does the calibration find these parameters?"

    def cases(self, setup: Setup, done: Done) -> Sequence[Case]:
        return [at_truth(setup), proof(setup), on_synthetic_by_posterior(setup, done, "mid", setup.short)]

    def findings(self, setup: Setup, done: Done) -> Findings:
        truth, iterative, posterior = self.cases(setup, done)
        results, reference = done.results(iterative), None if iterative.missing else setup.synthetic()
        found, by_posterior = fits(results), fits(done.results(posterior))
        scatter = floor(done.repeats(truth), reference.control, BOTH) if reference else {}
        table = Table(
            6,
            "Synthetic parameters and what is calibrated on their curve",
            (
                *(Row("synthetic", name, value, (value,)) for name, value in zip(paper.PARAMETERS, paper.TRUTH)),
                *rows("calibrated", PRINTED, found, scatter),
                *rows("calibrated", PRINTED, by_posterior, scatter, method=POSTERIOR),
            ),
        )
        return Findings((table,), self._figures(results, found, by_posterior, reference), self._conclusions(found, results, scatter))

    def _figures(self, results, found, by_posterior, reference):
        figures = {}
        if results:
            series = {f"seed {result.calibration.seed}": [each.gl_error for each in result.iterations] for result in results}
            figures[9] = over_iterations("figure-09", "GL error over iterations", f"Eq. 7 of the paper's method, a line a seed. The paper ends at {LAST_GL_ERROR} %.", series, "ε_{GL} [%]")
        curves = {f"{name}, seed {number}": each.response for name, many in (("calibrated", found), ("posterior", by_posterior)) for number, each in enumerate(many[:1], 1)}
        if curves:
            figures[10] = over_strain("figure-10", "Calibrated curves and the synthetic reference", "The first seed of each method.", curves, reference, dots="synthetic reference")
        return figures

    def _conclusions(self, found, results, scatter):
        errors = Values.of("the error ε of the calibrated parameters", [each.errors[ERROR] for each in found], scatter.get(ERROR))
        last = Values.of("the GL error of the last iteration", [result.iterations[-1].gl_error for result in results])
        apart = {name: off(shown, [each.numbers[name] for each in found], truth) for (name, shown), truth in zip(parameter_labels().items(), paper.TRUTH)}
        claims = {
            "The calibrated curve fits as well as a repeated run can: its error is at most 2 %.": at_most(errors, 2.0),
            "The GL error ends at about 2 %.": at_most(last, 2.5),
            "log E and φ come out close to the truth: within 1 % and 5 % of it.": all_of([at_most(apart["log_E"], 1.0), at_most(apart["phi"], 5.0)]),
            "ν, β_{m} and η_{m} are off by slightly more: by at most 20 %.": all_of([at_most(apart[name], 20.0) for name in ("nu", "beta_m", "eta_m")]),
        }
        return tuple(Conclusion(claim, judgement) for claim, judgement in claims.items())
