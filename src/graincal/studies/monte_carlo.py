"""Does iterating help, against one large set of samples? (section 3.1: Table 3, Figures 3 to 5)"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from graincal.data import Reference
from graincal.drawing.figure import Axis, Figure, Line, Mark, Panel, Points
from graincal.drawing.palette import REFERENCE, distinct
from graincal.studies import forecast, paper
from graincal.studies.common import at_toyoura
from graincal.studies.curves import over_iterations, over_strain
from graincal.studies.floors import STRAIN, STRESS, floor
from graincal.studies.found import ITERATIONS, QUANTITIES, Fit, fit_in, fits, labels, parameter_names, rows, values
from graincal.studies.judging import Judgement, Values, all_of, differ, smaller
from graincal.studies.records import Conclusion, Findings, Row, Table, conclusions
from graincal.studies.settings import BOTH, POSTERIOR, SEQUENTIAL, Setup
from graincal.studies.study import Case, Done, Study, calibrations

PARTICLES = 1000
PRESSURES = (0.2e6, 0.5e6, 1.0e6)
AS_MANY = 560
"""The evaluations of the paper's iterative calibration at 0.5 MPa, which the Monte Carlo filter is given too."""

GL = {
    0.2e6: (8.722, 0.078, 31.263, 0.436, 0.178),
    0.5e6: (*paper.TOYOURA, 1.65, 5.22, 3.44, 6),
    1.0e6: (8.961, 0.241, 25.441, 0.086, 0.944),
}
MC = {
    0.2e6: (8.736, 0.080, 30.203, 0.564, 0.194),
    0.5e6: (8.736, 0.080, 30.203, 0.564, 0.194, 6.22, 21.41, 13.82),
    1.0e6: (9.098, 0.439, 22.043, 0.076, 0.726),
}
"""Table 3; the errors at 0.5 MPa, and the last iteration there, are of the text. At the other pressures only a figure has them."""

RANGES = {("GL", STRESS): (1.65, 2.18), ("GL", STRAIN): (3.48, 7.91), ("MC", STRESS): (2.75, 7.53), ("MC", STRAIN): (4.77, 21.41)}
"""The smallest and the largest error over the three pressures, of the text."""

FACTORS = {STRESS: 3.77, STRAIN: 4.10}
"""What the text says that errors are divided by at 0.5 MPa."""


@dataclass(frozen=True)
class _At:
    """What was found at one confining pressure: the fits by GL, MC, MC 80 and posterior, the floor, the reference where there is one, and why nothing
    can be run where that is so.
    """

    pressure: float
    found: Mapping[str, list[Fit]]
    floor: Mapping[str, float]
    reference: Reference | None
    missing: str

    @property
    def name(self) -> str:
        return f"{self.pressure / 1e6:g} MPa"


class MonteCarlo(Study):
    name = "monte-carlo"
    title = "Iterating against one large set of samples"
    where = "section 3.1, Table 3, Figures 3 to 5"
    question = "Toyoura sand at three pressures: does the iterative filter fit better than the sequential Monte Carlo filter?"

    def cases(self, setup: Setup, done: Done) -> Sequence[Case]:
        runnable = [pressure for pressure in PRESSURES if not _missing(setup, pressure)]
        each = [case for pressure in PRESSURES for case in _cases(setup, pressure).values()]
        return [*(at_toyoura(setup, PARTICLES, pressure) for pressure in runnable), *each]

    def findings(self, setup: Setup, done: Done) -> Findings:
        at = [_found(setup, done, pressure) for pressure in PRESSURES]
        results = {each.name: done.results(_cases(setup, each.pressure)["GL"]) for each in at}
        series = {f"{name}, seed {result.calibration.seed}": [one.gl_error for one in result.iterations] for name, many in results.items() for result in many}
        notes = (
            "The paper does not say how many samples its Monte Carlo filter had: it is run with 80, which are iteration 0 of the iterative filter, "
            f"and with {AS_MANY}, as many as the paper's iterative filter took at 0.5 MPa.",
        )
        return Findings((_table(at), _errors_table(at)), _figures(at, series), _conclusions(at), notes)


def _missing(setup: Setup, pressure: float) -> str:
    return setup.missing(f"toyoura_{pressure / 1e6:.1f}MPa.csv", PARTICLES)


def _cases(setup: Setup, pressure: float) -> dict[str, Case]:
    """The calibrations at one pressure. The Monte Carlo filter with 80 samples is iteration 0 of the iterative one."""
    named, folder, missing = f"{pressure / 1e6:g} MPa", f"toyoura-1000-{pressure / 1e6:g}MPa", _missing(setup, pressure)
    parts = lambda: (setup.test(PARTICLES, pressure), setup.toyoura(pressure, BOTH))  # noqa: E731
    iterative = lambda seed: setup.by_the_paper(*parts(), seed=seed)  # noqa: E731
    sequential = lambda seed: setup.by_the_paper(*parts(), seed=seed, samples=AS_MANY, method=SEQUENTIAL)  # noqa: E731
    posterior = lambda seed: setup.by_the_posterior(*parts(), seed=seed)  # noqa: E731
    sizes = {
        "GL": forecast.by_the_paper(setup, PARTICLES, "mid", 80, 8),
        "MC": forecast.by_the_paper(setup, PARTICLES, "mid", AS_MANY, 1),
        "posterior": forecast.by_the_posterior(setup, PARTICLES, "mid"),
    }
    return {
        "GL": calibrations(f"{named}, GL", f"{folder}-alpha-10", iterative, setup.short, sizes["GL"], missing),
        "MC": calibrations(f"{named}, MC with {AS_MANY} samples", f"{folder}-mc-{AS_MANY}", sequential, setup.short, sizes["MC"], missing),
        "posterior": calibrations(f"{named}, posterior", f"{folder}-posterior", posterior, setup.short, sizes["posterior"], missing),
    }


def _found(setup: Setup, done: Done, pressure: float) -> _At:
    results = {name: done.results(case) for name, case in _cases(setup, pressure).items()}
    found = {name: fits(many) for name, many in results.items()}
    found["MC 80"] = [fit for result in results["GL"] if (fit := fit_in(result, result.iterations[0]))]
    if missing := _missing(setup, pressure):
        return _At(pressure, found, {}, None, missing)
    reference = setup.toyoura(pressure, BOTH)
    return _At(pressure, found, floor(done.repeats(at_toyoura(setup, PARTICLES, pressure)), reference.control, BOTH), reference, "")


def _table(at: Sequence[_At]) -> Table:
    lines: list[Row] = []
    quantities = (*QUANTITIES, ITERATIONS)
    for each in at:
        printed = {name: dict(zip(quantities, of[each.pressure])) for name, of in (("GL", GL), ("MC", MC))}
        lines += rows(f"{each.name}, GL", printed["GL"], each.found["GL"], each.floor, quantities, missing=each.missing)
        lines += rows(f"{each.name}, GL", printed["GL"], each.found["posterior"], each.floor, method=POSTERIOR)
        lines += rows(f"{each.name}, MC with 80 samples", printed["MC"], each.found["MC 80"], each.floor, missing=each.missing)
        lines += rows(f"{each.name}, MC with {AS_MANY} samples", printed["MC"], each.found["MC"], each.floor, missing=each.missing)
    return Table(3, "Parameters by the iterative filter (GL) and the Monte Carlo filter (MC)", tuple(lines))


def _errors_table(at: Sequence[_At]) -> Table:
    """What the text prints of the errors: their ranges over the pressures, and what they are divided by."""
    missing = next((each.missing for each in at if each.missing), "")
    lines = []
    for (who, quantity), printed in RANGES.items():
        medians = [float(np.median([fit.errors[quantity] for fit in each.found[who]])) for each in at if each.found[who]]
        for which, value, ours in zip(("smallest", "largest"), printed, (min(medians, default=np.nan), max(medians, default=np.nan))):
            # Over two pressures they are no numbers that compare with the paper's.
            lines.append(Row(f"{who}, {which} of three pressures", quantity, value, (ours,) if len(medians) == len(PRESSURES) else (), missing=missing))
    for each in at:
        for quantity in (STRESS, STRAIN):
            factors = [one.errors[quantity] / other.errors[quantity] for one, other in zip(each.found["MC"], each.found["GL"])]
            lines.append(Row(f"{each.name}, MC over GL", quantity, FACTORS[quantity] if each.pressure == 0.5e6 else None, tuple(factors), missing=each.missing))
    notes = ("Ours over all pressures are of the medians over seeds, and where all three are there. The last three rows are ratios, seed by seed.",)
    return Table("monte-carlo", "Errors of both filters", tuple(lines), notes)


def _conclusions(at: Sequence[_At]) -> tuple[Conclusion, ...]:
    claims = {}
    for each in at:
        printed = " (the paper: 3.77 and 4.10 times)" if each.pressure == 0.5e6 else ""
        claims[f"At {each.name} the iterative filter fits both observables better than the Monte Carlo filter with {AS_MANY} samples{printed}."] = _better(each)
    middle = next(each for each in at if each.pressure == 0.5e6)
    claims["At 0.5 MPa both filters end in different minima: ν, β_{m} and η_{m} differ."] = _other_minimum(middle)
    claims["log E and ν rise, and φ falls, with the confining pressure."] = _by_pressure(at)
    return conclusions(claims)


def _better(at: _At) -> Judgement:
    compared = [
        [values(f"{labels()[quantity].removesuffix(' [%]')} of {name} at {at.name}", at.found[name], quantity, at.floor) for name in ("GL", "MC")]
        for quantity in (STRESS, STRAIN)
    ]
    judged = all_of([smaller(*each) for each in compared])
    if not (at.found["GL"] and at.found["MC"]):
        return judged
    took = [np.median([fit.evaluations for fit in at.found[name]]) for name in ("GL", "MC")]
    return Judgement(judged.verdict, f"{judged.reason} GL took {took[0]:.0f} evaluations and MC {took[1]:.0f} (medians).")


def _parameter(at: _At, who: str, name: str) -> Values:
    return values(f"{parameter_names()[name]} of {who} at {at.name}", at.found[who], name, {}, unit="")


def _other_minimum(at: _At) -> Judgement:
    return all_of([differ(_parameter(at, "GL", name), _parameter(at, "MC", name)) for name in ("nu", "beta_m", "eta_m")])


def _by_pressure(at: Sequence[_At]) -> Judgement:
    steps = []
    for name, rises in (("log_E", True), ("nu", True), ("phi", False)):
        found = [_parameter(each, "GL", name) for each in at]
        steps += [smaller(one, other) if rises else smaller(other, one) for one, other in zip(found, found[1:])]
    return all_of(steps)


def _figures(at: Sequence[_At], series: Mapping[str, Sequence[float]]) -> dict[int, Figure]:
    figures = {}
    if curves := {f"{each.name}, {name}": each.found[name][0].response for each in at for name in ("GL", "MC", "posterior") if each.found[name]}:
        references = {f"measured, {each.name}": each.reference for each in at if each.reference is not None and each.found["GL"]}
        figures[3] = over_strain("figure-03", "Toyoura sand", "The first seed of each method.", curves, references)
    if arrows := {each.name: _arrow(each) for each in at if each.found["GL"] and each.found["MC"]}:
        marks: list[Mark] = []
        for number, (named, (stress, strain)) in enumerate(arrows.items()):
            marks += [Line(stress, strain, distinct(number), f"{named}, from MC to GL"), Points(stress[:1], strain[:1], REFERENCE, "MC")]
        caption = "A line for each pressure, of the first seed; the ring at its end is the Monte Carlo filter."
        figures[4] = Figure(
            "figure-04", "Errors of both observables, by MC and by GL", caption, (Panel("", Axis(STRESS), Axis(STRAIN), tuple(marks)),), columns=1
        )
    if series:
        caption = "Eq. 7, a line for each seed. The paper's calibrations end between iterations 6 and 10, at 3.58 to 5.98 %."
        figures[5] = over_iterations("figure-05", "GL error over iterations", caption, series, "ε_{GL} [%]")
    return figures


def _arrow(at: _At) -> tuple[np.ndarray, np.ndarray]:
    """The errors of stress and of strain, each (2,), of MC and GL."""
    stress, strain = (np.array([at.found[name][0].errors[quantity] for name in ("MC", "GL")]) for quantity in (STRESS, STRAIN))
    return stress, strain
