"""Does the answer depend on the number of particles? (section 3.2: Table 4, Figure 6)"""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence

import numpy as np

from graincal.data import Reference
from graincal.models import TriaxialTest
from graincal.studies import forecast, paper
from graincal.studies.common import PRESSURE, at_toyoura
from graincal.studies.curves import over_strain
from graincal.studies.floors import ERROR, floor
from graincal.studies.found import ITERATIONS, QUANTITIES, Fit, fits, parameter_names, rows
from graincal.studies.judging import all_of
from graincal.studies.records import Conclusion, Findings, Row, Table, conclusions
from graincal.studies.settings import POSTERIOR, STRESS_TRUSTED, Setup
from graincal.studies.study import Case, Done, Study, calibrations
from graincal.studies.trend import no_trend

LARGE = 27000
MOST_BY_POSTERIOR = 2000
"""Grains up to which the method "posterior" is run beside the paper's."""

PRINTED = {
    1000: (8.753, 0.152, 34.327, 0.065, 0.324, 3.39, 7.58, 4.23),
    2000: (8.727, 0.226, 28.479, 0.076, 0.576, 3.11, 6.62, 3.81, 11),
    5000: (8.973, 0.079, 24.923, 0.352, 0.284, 2.41, 11.56, 4.24),
    8000: (8.812, 0.131, 29.733, 0.095, 0.707, 2.01, 6.82, 2.97),
    10000: (8.800, 0.126, 26.960, 0.153, 0.409, 2.51, 5.82, 3.17),
    LARGE: (8.683, 0.296, 33.055, 0.036, 0.567, 2.69, 10.65, 4.28),
}
"""Table 4, in the order of the parameters and errors; the last iteration of that of 2,000 is of the text."""

DIFFER = {name: max(each[column] for each in PRINTED.values()) - min(each[column] for each in PRINTED.values()) for column, name in enumerate(paper.PARAMETERS)}
"""What the paper's six calibrations differ by in each parameter, which it calls no trend."""


def on_toyoura(setup: Setup, particles: int, seeds: Iterable[int]) -> Case:
    """The paper's method on Toyoura sand at 0.5 MPa, the stress ratio trusted four times as much."""
    make = lambda seed: setup.by_the_paper(*_parts(setup, particles), seed=seed)  # noqa: E731
    size = forecast.by_the_paper(setup, particles, "mid", 80, 12)
    return calibrations(named(setup, particles), f"{_folder(setup, particles)}-stress-trusted-alpha-10", make, seeds, size, _missing(setup))


def on_toyoura_by_posterior(setup: Setup, particles: int, seeds: Iterable[int]) -> Case:
    """The same by the method "posterior"."""
    make = lambda seed: setup.by_the_posterior(*_parts(setup, particles), seed=seed)  # noqa: E731
    size = forecast.by_the_posterior(setup, particles, "mid")
    return calibrations(f"{named(setup, particles)}, posterior", f"{_folder(setup, particles)}-stress-trusted-posterior", make, seeds, size, _missing(setup))


class Particles(Study):
    name = "particles"
    title = "The number of particles"
    where = "section 3.2, Table 4, Figure 6"
    question = "Does what is calibrated on Toyoura sand at 0.5 MPa depend on how many particles stand for it?"

    def cases(self, setup: Setup, done: Done) -> Sequence[Case]:
        replicates = [at_toyoura(setup, particles) for particles in PRINTED if particles != LARGE or setup.large]
        return [*(replicates if not _missing(setup) else []), *_calibrations(setup).values(), *_posteriors(setup).values()]

    def findings(self, setup: Setup, done: Done) -> Findings:
        cases = _calibrations(setup)
        found = {particles: fits(done.results(case)) for particles, case in cases.items()}
        by_posterior = {particles: fits(done.results(case)) for particles, case in _posteriors(setup).items()}
        floors = _floors(setup, done)
        lines: list[Row] = []
        for particles, printed in PRINTED.items():
            quantities = (*QUANTITIES, ITERATIONS)
            numbers, name = dict(zip(quantities, printed)), named(setup, particles)
            lines += rows(name, numbers, found[particles], floors[particles], quantities, missing=cases[particles].missing)
            lines += rows(name, numbers, by_posterior.get(particles, []), floors[particles], method=POSTERIOR)
        curves = {named(setup, particles): many[0].response for particles, many in found.items() if many}
        figures = {}
        if curves:
            references = {"measured": setup.toyoura(PRESSURE, STRESS_TRUSTED)}
            figures[6] = over_strain("figure-06", "Toyoura sand at 0.5 MPa by packings of several sizes", "The first seed of each.", curves, references)
        return Findings((Table(4, "Parameters by the number of particles", tuple(lines), _notes()),), figures, _conclusions(found, floors))


def named(setup: Setup, particles: int) -> str:
    """A number of particles, and whether they are a packing of graincal's own."""
    own = "" if setup.has_packing(particles) and not setup.own_everywhere else ", own packing"
    return f"{particles} particles{own}"


def _parts(setup: Setup, particles: int) -> tuple[TriaxialTest, Reference]:
    return setup.test(particles, PRESSURE, own=True), setup.toyoura(PRESSURE, STRESS_TRUSTED)


def _missing(setup: Setup) -> str:
    return setup.missing("toyoura_0.5MPa.csv", None)


def _folder(setup: Setup, particles: int) -> str:
    """Of work on a packing of so many grains: where the data folder comes to hold the paper's, it is other work."""
    return f"toyoura-{particles}{'' if setup.has_packing(particles) else '-own'}"


def _calibrations(setup: Setup) -> dict[int, Case]:
    cases = {particles: on_toyoura(setup, particles, setup.short if particles <= 1000 else setup.long) for particles in PRINTED}
    if not setup.large:
        cases[LARGE] = Case(named(setup, LARGE), missing="it is run only with --large")
    return cases


def _posteriors(setup: Setup) -> dict[int, Case]:
    return {particles: on_toyoura_by_posterior(setup, particles, setup.long) for particles in PRINTED if particles <= MOST_BY_POSTERIOR}


def _floors(setup: Setup, done: Done) -> dict[int, dict[str, float]]:
    if _missing(setup):
        return {particles: {} for particles in PRINTED}
    control = setup.toyoura(PRESSURE, STRESS_TRUSTED).control
    return {particles: floor(done.repeats(at_toyoura(setup, particles)), control, STRESS_TRUSTED) for particles in PRINTED}


def _notes() -> tuple[str, ...]:
    return (
        "ε counts the stress ratio four times as much as volumetric strain (Eq. 6 with shares of 0.2 and 0.8).",
        "Packings that the data folder lacks are prepared by graincal, with the same void ratio and grading, and are another sample of the material.",
        f'The method "posterior" is run with up to {MOST_BY_POSTERIOR} particles: on larger packings its 800 runs would take most of the time of all studies.',
    )


def _conclusions(found: Mapping[int, Sequence[Fit]], floors: Mapping[int, Mapping[str, float]]) -> tuple[Conclusion, ...]:
    def by_size(quantity: str) -> dict[int, list[float]]:
        return {particles: [fit.numbers[quantity] for fit in many] for particles, many in found.items() if many}

    # Not known where it is not for one of the sizes.
    known = float(np.max([floors[particles].get(ERROR, np.nan) for particles, many in found.items() if many] or [np.nan]))
    claims = {
        "No parameter has a trend with the number of particles: none changes along the sizes by more than the paper's calibrations differ by.": all_of(
            [no_trend(label, by_size(name), DIFFER[name]) for name, label in parameter_names().items()]
        ),
        "ε does not fall with the number of particles, by more than runs at the same parameters differ.": no_trend(
            "ε", by_size(ERROR), known, " %", falls_only=True
        ),
    }
    return conclusions(claims)
