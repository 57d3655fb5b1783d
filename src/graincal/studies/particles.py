"""Does the answer depend on the number of particles? (section 3.2: Table 4, Figure 6)"""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence

from graincal.studies import forecast, paper
from graincal.studies.common import runs_at
from graincal.studies.curves import over_strain
from graincal.studies.found import ERROR, STRAIN, STRESS, Fit, fits, floor, rows
from graincal.studies.records import CANNOT_BE_TOLD, HOLDS, Conclusion, Findings, Judgement, Table, Values, smaller
from graincal.studies.settings import POSTERIOR, STRESS_TRUSTED, Setup
from graincal.studies.study import Case, Done, Study, calibrations

PRESSURE = 0.5e6
LARGE = 27000
MOST_BY_POSTERIOR = 2000
"""Grains up to which the method "posterior" is run beside the paper's."""

PRINTED = {
    1000: (8.753, 0.152, 34.327, 0.065, 0.324, 3.39, 7.58, 4.23),
    2000: (8.727, 0.226, 28.479, 0.076, 0.576, 3.11, 6.62, 3.81),
    5000: (8.973, 0.079, 24.923, 0.352, 0.284, 2.41, 11.56, 4.24),
    8000: (8.812, 0.131, 29.733, 0.095, 0.707, 2.01, 6.82, 2.97),
    10000: (8.800, 0.126, 26.960, 0.153, 0.409, 2.51, 5.82, 3.17),
    LARGE: (8.683, 0.296, 33.055, 0.036, 0.567, 2.69, 10.65, 4.28),
}


def on_toyoura(setup: Setup, particles: int, seeds: Iterable[int]) -> Case:
    """The paper's method on Toyoura sand at 0.5 MPa, the stress ratio trusted four times as much."""
    make = lambda seed: setup.by_the_paper(setup.test(particles, PRESSURE, own=True), setup.toyoura(PRESSURE, STRESS_TRUSTED), seed=seed)  # noqa: E731
    return calibrations(_named(setup, particles), f"{_folder(setup, particles)}-stress-trusted-alpha-10", make, seeds, forecast.by_the_paper(setup, particles, "mid", 80, 12), setup.missing("toyoura_0.5MPa.csv", None))


class Particles(Study):
    name = "particles"
    title = "The number of particles"
    where = "section 3.2, Table 4, Figure 6"
    question = "Does what is calibrated on Toyoura sand at 0.5 MPa depend on how many particles stand for it?"

    def cases(self, setup: Setup, done: Done) -> Sequence[Case]:
        return [self._replicates(setup), *self._calibrations(setup).values(), *self._posteriors(setup).values()]

    def _replicates(self, setup: Setup) -> Case:
        return runs_at(setup, "runs at the paper's calibrated parameters", "runs-at-toyoura-1000", [paper.TOYOURA], particles=1000)

    def _calibrations(self, setup: Setup) -> dict[int, Case]:
        cases = {particles: on_toyoura(setup, particles, setup.short if particles <= 1000 else setup.long) for particles in PRINTED}
        if not setup.large:
            cases[LARGE] = Case(_named(setup, LARGE), missing="it is run with --large alone")
        return cases

    def _posteriors(self, setup: Setup) -> dict[int, Case]:
        def case(particles: int) -> Case:
            make = lambda seed: setup.by_the_posterior(setup.test(particles, PRESSURE, own=True), setup.toyoura(PRESSURE, STRESS_TRUSTED), seed=seed)  # noqa: E731
            return calibrations(f"{_named(setup, particles)}, posterior", f"{_folder(setup, particles)}-stress-trusted-posterior", make, setup.long, forecast.by_the_posterior(setup, particles, "mid"), setup.missing("toyoura_0.5MPa.csv", None))

        return {particles: case(particles) for particles in PRINTED if particles <= MOST_BY_POSTERIOR}

    def findings(self, setup: Setup, done: Done) -> Findings:
        cases = self._calibrations(setup)
        reference = None if cases[1000].missing else setup.toyoura(PRESSURE, STRESS_TRUSTED)
        scatter = floor(done.repeats(self._replicates(setup)), reference.control, STRESS_TRUSTED) if reference else {}
        found = {particles: fits(done.results(case)) for particles, case in cases.items()}
        by_posterior = {particles: fits(done.results(case)) for particles, case in self._posteriors(setup).items()}
        lines = []
        for particles, printed in PRINTED.items():
            numbers, named = dict(zip((*paper.PARAMETERS, STRESS, STRAIN, ERROR), printed)), _named(setup, particles)
            lines += rows(named, numbers, found[particles], scatter) + rows(named, numbers, by_posterior.get(particles, []), scatter, method=POSTERIOR)
        curves = {_named(setup, particles): many[0].response for particles, many in found.items() if many}
        figures = {6: over_strain("figure-06", "Toyoura sand at 0.5 MPa by packings of several sizes", "The first seed of each.", curves, reference, dots="measured")} if curves else {}
        notes = ("ε counts the stress ratio four times as much as volumetric strain (Eq. 6 with shares of 0.2 and 0.8).", "Packings that the data folder lacks are prepared by graincal, with the same void ratio and grading, and are another sample of the material.", f'The method "posterior" is run with up to {MOST_BY_POSTERIOR:,} particles.'.replace(",", "\u202f"))
        return Findings((Table(4, "Parameters by the number of particles", tuple(lines), notes),), figures, _conclusions(found, scatter))


def _named(setup: Setup, particles: int) -> str:
    own = "" if setup.has_packing(particles) and not setup.own_everywhere else ", own packing"
    return f"{particles} particles{own}"


def _folder(setup: Setup, particles: int) -> str:
    """Of work on a packing of so many grains: where the data folder comes to hold the paper's, it is other work."""
    return f"toyoura-{particles}{'' if setup.has_packing(particles) else '-own'}"


def _conclusions(found: Mapping[int, list[Fit]], scatter: Mapping[str, float]) -> tuple[Conclusion, ...]:
    errors = {particles: [each.errors[ERROR] for each in many] for particles, many in found.items() if many}
    return (Conclusion("ε does not fall with the number of particles.", _no_trend(errors, scatter.get(ERROR, 0.0))),)


def _no_trend(errors: Mapping[int, list[float]], scatter: float) -> Judgement:
    """Whether the largest packing fits no better than the smallest."""
    if len(errors) < 2:
        return Judgement(CANNOT_BE_TOLD, "Packings of two sizes at least are needed.")
    few, many = min(errors), max(errors)
    falls = smaller(Values.of(f"ε with {many} particles", errors[many], scatter), Values.of(f"ε with {few}", errors[few], scatter))
    return falls if falls.verdict == CANNOT_BE_TOLD else Judgement(HOLDS if falls.verdict != HOLDS else "does not hold", falls.reason)
