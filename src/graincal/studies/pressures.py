"""Does what was calibrated at one pressure predict others? (section 4.3: Table 10, Figure 14)"""

from __future__ import annotations

from collections.abc import Mapping, Sequence

from graincal.data import Response
from graincal.studies import paper
from graincal.studies.common import proof, proof_by_posterior, runs_after, runs_at
from graincal.studies.curves import over_strain
from graincal.studies.floors import ERROR, STRAIN, STRAINS, STRESS, at, errors_between, floor, mean_run
from graincal.studies.found import fits
from graincal.studies.judging import EXACT, RUN, Values, all_of, at_most
from graincal.studies.records import Findings, Row, Table, conclusions
from graincal.studies.settings import BOTH, ITERATIVE, POSTERIOR, Setup
from graincal.studies.study import Case, Done, Study

PRINTED = {0.2e6: {STRESS: 2.68, STRAIN: 2.60, ERROR: 2.64}, 1.0e6: {STRESS: 1.11, STRAIN: 2.26, ERROR: 1.69}}


class Pressures(Study):
    name = "pressures"
    title = "Other confining pressures"
    where = "section 4.3, Table 10, Figure 14"
    question = "Do parameters that were calibrated at 0.5 MPa predict tests at 0.2 and 1.0 MPa?"

    def cases(self, setup: Setup, done: Done) -> Sequence[Case]:
        return [proof(setup), proof_by_posterior(setup, done), *(case for pressure in PRINTED for case in _cases(setup, done, pressure).values())]

    def findings(self, setup: Setup, done: Done) -> Findings:
        lines, judged = [], []
        curves: dict[str, Response] = {}
        for pressure, printed in PRINTED.items():
            cases, setting = _cases(setup, done, pressure), f"{pressure / 1e6:g} MPa"
            runs = {who: at(done.all_runs(case), STRAINS) for who, case in cases.items()}
            errors = {who: _errors(many, runs["truth"]) for who, many in runs.items() if who != "truth"}
            scatter = floor(runs["truth"], STRAINS, BOTH)
            lines += _rows(f"{setting}, the paper's parameters", printed, errors["paper"], scatter, cases["paper"].missing, "")
            lines += _rows(f"{setting}, our parameters", {}, errors[ITERATIVE], scatter, cases[ITERATIVE].missing, ITERATIVE)
            lines += _rows(f"{setting}, our parameters", {}, errors[POSTERIOR], scatter, cases[POSTERIOR].missing, POSTERIOR)
            # What runs differ by is in the limit, and is not counted twice.
            error = Values.of_finite(f"ε at {setting} by the paper's parameters", errors["paper"][ERROR], EXACT if scatter else None, of=RUN)
            judged.append(at_most(error, printed[ERROR] + scatter.get(ERROR, 0.0)))
            shown = (("exact parameters", "truth"), ("the paper's calibrated", "paper"))
            curves |= {f"{name}, {setting}": mean_run(runs[who]) for name, who in shown if runs[who]}
        notes = ("Each run is compared with a run at the exact parameters at the same pressure.",)
        table = Table(10, "Prediction errors at pressures that nothing was calibrated at", tuple(lines), notes)
        figures = {14: over_strain("figure-14", "Predictions at other confining pressures", "Means of repeated runs.", curves)} if curves else {}
        return Findings((table,), figures, conclusions({_CLAIM: all_of(judged)}))


_CLAIM = (
    "Parameters that were calibrated at one pressure predict the test at others: "
    "errors are at most the paper's plus what runs at the same parameters differ by."
)


def _cases(setup: Setup, done: Done, pressure: float) -> dict[str, Case]:
    """The runs at one pressure, by whose parameters they are."""
    at_pressure, count = f"{pressure / 1e6:g}MPa", len(setup.short)
    named = f"at {pressure / 1e6:g} MPa"

    def own(who: str, name: str, calibrated: Case) -> Case:
        theta = lambda: [each.theta for each in fits(done.results(calibrated))]  # noqa: E731
        return runs_after(setup, f"{who} {named}", f"{name}-{at_pressure}-{count}", theta, count, calibrated, pressure=pressure)

    return {
        "truth": runs_at(setup, f"the exact parameters {named}", f"runs-at-truth-{at_pressure}", [paper.TRUTH], pressure=pressure),
        "paper": runs_at(setup, f"the paper's calibrated parameters {named}", f"runs-at-calibrated-{at_pressure}", [paper.CALIBRATED], pressure=pressure),
        ITERATIVE: own("our calibrated parameters", "runs-at-own", proof(setup)),
        POSTERIOR: own('our answers by "posterior"', "runs-at-posterior", proof_by_posterior(setup, done)),
    }


def _rows(
    setting: str, printed: Mapping[str, float], errors: Mapping[str, tuple[float, ...]], scatter: Mapping[str, float], missing: str, method: str
) -> list[Row]:
    return [Row(setting, name, printed.get(name), values, scatter.get(name), method, missing) for name, values in errors.items()]


def _errors(runs: Sequence[Response], truth: Sequence[Response]) -> dict[str, tuple[float, ...]]:
    """Eq. 5 and 6 of each run against the run at the truth of its number."""
    pairs = [errors_between(run.values, truth[number % len(truth)].values, BOTH) for number, run in enumerate(runs)] if truth else []
    return {name: tuple(pair[name] for pair in pairs) for name in (STRESS, STRAIN, ERROR)}
