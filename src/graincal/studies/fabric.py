"""Does a fit to curves give the right structure? (section 4.4: Tables 11 and 12, Figure 15)"""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np

from graincal.data import Response
from graincal.inference.errors import curve_error
from graincal.notation.quantities import quantity
from graincal.report.drawing import Figure
from graincal.studies.common import at_truth, runs_at
from graincal.studies.curves import difference
from graincal.studies.found import STRAIN, STRESS, Fit, at, fit, floor_of, mean_run
from graincal.studies.range_alpha import SETTINGS, Setting, cases_by_setting
from graincal.studies.records import Conclusion, Findings, Row, Table, Values, all_of, at_most, smaller
from graincal.studies.settings import Setup
from graincal.studies.study import Case, Done, Study

FABRIC = {"coordination_number": "ε_{Z} [%]", "a_c": "ε_{ac} [%]", "a_n": "ε_{an} [%]", "a_t": "ε_{at} [%]"}
STRAINS = np.linspace(0, 0.2, 51)

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


class Fabric(Study):
    name = "fabric"
    title = "The structure behind the curves"
    where = "section 4.4, Tables 11 and 12, Figure 15"
    question = "Parameters that fit the curves: do they give the coordination number and the fabric of the true ones too?"

    def cases(self, setup: Setup, done: Done) -> Sequence[Case]:
        return [at_truth(setup), *self._at_printed(setup).values(), *cases_by_setting(setup).values()]

    def _at_printed(self, setup: Setup) -> dict[str, Case]:
        """Runs at the parameters that the paper printed of four calibrations."""
        chosen = {setting.name: setting for setting in SETTINGS if setting.name in PRINTED}
        return {name: runs_at(setup, f"the paper's parameters of {name}", f"runs-at-{name.replace(' ', '-').replace(',', '').replace('-α-=', '-alpha')}", [chosen[name].printed[:5]]) for name in PRINTED}

    def findings(self, setup: Setup, done: Done) -> Findings:
        runs = at(done.repeats(at_truth(setup)), STRAINS)
        truth = mean_run(runs) if runs else None
        single = {name: floor_of(runs, name) for name in FABRIC}
        found = {name: at(done.repeats(case), STRAINS) for name, case in self._at_printed(setup).items()}
        # A mean of several runs scatters less than one of them.
        means, scatter = {name: mean_run(many) for name, many in found.items() if many}, {name: single[name] / np.sqrt(max(1, len(runs))) for name in FABRIC}
        apart = {name: _errors(mean, truth) for name, mean in means.items()} if truth else {}
        best = {setting: own for setting, case in cases_by_setting(setup).items() for result in done.results(case)[:1] if (own := fit(result)) and at([own.response], STRAINS)}
        of_best = {setting: _errors(at([own.response], STRAINS)[0], truth) for setting, own in best.items()} if truth else {}
        figures = {15: _figure(means, truth)} if truth and means else {}
        return Findings((_table_11(apart, of_best, single, scatter), _table_12(best, of_best)), figures, _conclusions(apart, scatter, best, of_best), (_HOW,))


_HOW = "The rows at the paper's parameters are means of repeated runs, compared with the mean of runs at the exact parameters; those of our own calibrations are single runs."


def _errors(run: Response, truth: Response) -> dict[str, float]:
    """Eq. 5 of each quantity of the fabric."""
    return {name: curve_error(run.values[name], truth.values[name]) for name in FABRIC}


def _table_11(apart: Mapping[str, dict[str, float]], of_best: Mapping[Setting, dict[str, float]], single: Mapping[str, float], scatter: Mapping[str, float]) -> Table:
    lines = []
    for setting, printed in PRINTED.items():
        errors = apart.get(setting, {})
        lines += [Row(f"{setting}, the paper's parameters", FABRIC[name], value, (errors[name],) if errors else (), scatter[name]) for name, value in zip(FABRIC, printed)]
    lines += [Row(f"{setting.name}, our parameters", FABRIC[name], None, (value,), single[name]) for setting, errors in of_best.items() for name, value in errors.items()]
    return Table(11, "Errors of the fabric", tuple(lines))


def _table_12(best: Mapping[Setting, Fit], of_best: Mapping[Setting, dict[str, float]]) -> Table:
    correlations = _correlations(best, of_best)
    lines = [Row(f"{observable} and", FABRIC[name], value, (correlations[observable, name],) if correlations else ()) for observable, printed in CORRELATIONS.items() for name, value in zip(FABRIC, printed)]
    notes = (f"Ours are over {len(of_best)} calibrations, the first seed of each setting of the study of ranges.", "The paper's do not follow from the four rows of its Table 11; which calibrations went in is not said.")
    return Table(12, "Correlations between errors of the curves and of the fabric", tuple(lines), notes)


def _correlations(best: Mapping[Setting, Fit], of_best: Mapping[Setting, dict[str, float]]) -> dict[tuple[str, str], float]:
    """Pearson's coefficients; none for fewer than four calibrations."""
    if len(of_best) < 4:
        return {}
    return {(observable, name): float(np.corrcoef([best[setting].errors[observable] for setting in of_best], [errors[name] for errors in of_best.values()])[0, 1]) for observable in CORRELATIONS for name in FABRIC}


def _figure(means: Mapping[str, Response], truth: Response) -> Figure:
    panels = tuple(difference(quantity(name).title, {label: mean.values[name] - truth.values[name] for label, mean in means.items()}, STRAINS, name) for name in FABRIC)
    return Figure("figure-15", "Differences of the fabric to that of the exact parameters", "Means of repeated runs at the paper's parameters of four calibrations, less the mean at the exact parameters.", panels, columns=2)


def _conclusions(apart: Mapping[str, dict[str, float]], scatter: Mapping[str, float], best: Mapping[Setting, Fit], of_best: Mapping[Setting, dict[str, float]]) -> tuple[Conclusion, ...]:
    def error(setting: str, name: str) -> Values:
        return Values.of(f"{FABRIC[name].removesuffix(' [%]')} of {setting}", [apart[setting][name]] if setting in apart else [], scatter[name])

    largest = [smaller(error(other, name), error("wide, α = 5", name)) for name in FABRIC for other in PRINTED if other != "wide, α = 5"]
    apart_by_grade = [smaller(error(good, name), error(poor, name)) for name in ("coordination_number", "a_c", "a_n") for poor in POOR for good in GOOD]
    correlations = _correlations(best, of_best)
    with_stress = [at_most(Values.of(f"the correlation of the errors of stress and {FABRIC[name].removesuffix(' [%]')}, below 1,", [1 - correlations[STRESS, name]] if correlations else [], unit=""), 0.3) for name in FABRIC]
    claims = {
        "The worst fit of the wide range, with α = 5, has the largest error of each quantity of the fabric.": all_of(largest),
        "Sub-optimal parameters give a worse coordination number, a_{c} and a_{n} than optimal ones.": all_of(apart_by_grade),
        "Errors of the stress ratio go with errors of all quantities of the fabric: correlations are 0.7 or more.": all_of(with_stress),
    }
    return tuple(Conclusion(claim, judgement) for claim, judgement in claims.items())

