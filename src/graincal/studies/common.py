"""The cases that several studies share: by the same names they are the same work."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Sequence
from dataclasses import replace

from graincal.campaign import Calibration
from graincal.studies import forecast, paper
from graincal.studies.floors import floor
from graincal.studies.settings import BOTH, Setup, space
from graincal.studies.study import Case, Done, calibrations
from graincal.studies.work import Calibrating, Parameters, Running, Work

SYNTHETIC_PARTICLES, PRESSURE = 2000, 0.5e6


def on_synthetic(
    setup: Setup,
    box: str,
    samples: int,
    seeds: Iterable[int],
    iterations: int = forecast.ITERATIONS,
    most_iterations: int = paper.MOST_ITERATIONS,
    recorded: tuple[str, ...] = (),
) -> Case:
    """The paper's method on the synthetic reference."""

    def make(seed: int) -> Calibration:
        test, reference = setup.test(SYNTHETIC_PARTICLES, PRESSURE), setup.synthetic(recorded)
        return setup.by_the_paper(test, reference, seed=seed, samples=samples, box=box, most_iterations=most_iterations)

    alpha, only = round(samples / 8.05), "-stress-only" if recorded else ""
    size = forecast.by_the_paper(setup, SYNTHETIC_PARTICLES, box, samples, iterations)
    said = ", stress only" if recorded else ""
    return calibrations(f"{box}, α = {alpha}{said}", f"synthetic-{box.replace(' ', '-')}-alpha-{alpha}{only}", make, seeds, size, needs_synthetic(setup))


def on_synthetic_by_posterior(setup: Setup, done: Done, box: str, seeds: Iterable[int], recorded: tuple[str, ...] = ()) -> Case:
    """The method "posterior" on the synthetic reference, a run on the packing itself.

    Any but that of both observables and the mid range learns from the runs of that one's first seed, for they are of the same model.
    """

    def make(seed: int) -> Calibration:
        reference = setup.synthetic(recorded)
        return setup.by_the_posterior(setup.test(SYNTHETIC_PARTICLES, PRESSURE), reference, seed=seed, box=box, same_packing=True)

    only, alone = "-stress-only" if recorded else "", box == "mid" and not recorded
    size = forecast.by_the_posterior(setup, SYNTHETIC_PARTICLES, box, with_runs=not alone)
    said = ", stress only" if recorded else ""
    case = calibrations(f"{box}, posterior{said}", f"synthetic-{box.replace(' ', '-')}-posterior{only}", make, seeds, size, needs_synthetic(setup))
    if case.missing or alone:
        return case
    first = on_synthetic_by_posterior(setup, done, "mid", [1]).work[0]
    learning = tuple(replace(each, runs_of=done.folder_of(first)) for each in case.work if isinstance(each, Calibrating))
    return replace(case, work=learning, after=(first,))


def needs_synthetic(setup: Setup) -> str:
    """What the synthetic studies lack."""
    return setup.missing("synthetic_reference.csv", SYNTHETIC_PARTICLES)


def runs_at(
    setup: Setup,
    setting: str,
    name: str,
    theta: Sequence[tuple[float, ...]],
    *,
    particles: int = SYNTHETIC_PARTICLES,
    pressure: float = PRESSURE,
    own: bool = False,
) -> Case:
    """Repeated runs at parameters. own: on a packing that graincal prepares where the data folder has none."""
    if missing := setup.missing(None, None if own else particles):
        return Case(setting, missing=missing)
    return Case(setting, (_running(setup, setting, name, lambda: theta, len(theta), setup.size.repeats, particles, pressure, own),))


def runs_after(
    setup: Setup,
    setting: str,
    name: str,
    theta: Callable[[], Parameters],
    count: int,
    after: Case,
    *,
    pressure: float = PRESSURE,
) -> Case:
    """A run at each of so many parameters that are known once another case is at its end."""
    if after.missing:
        return Case(setting, missing=after.missing)
    work = _running(setup, setting, name, theta, count, 1, SYNTHETIC_PARTICLES, pressure, False)
    return Case(setting, (work,), after=after.work)


def _running(
    setup: Setup,
    setting: str,
    name: str,
    theta: Callable[[], Parameters],
    count: int,
    times: int,
    particles: int,
    pressure: float,
    own: bool,
) -> Work:
    size = forecast.runs(setup, particles, count * times)
    return Running(name, setting, size, lambda: setup.test(particles, pressure, own), theta, times, space("extra wide"), workers=setup.workers)


def at_truth(setup: Setup) -> Case:
    """Runs at the exact parameters of the synthetic reference: by what they differ is the floor of all studies on it, and their fabric is what others
    are compared with.
    """
    return runs_at(setup, "runs at the exact parameters", "runs-at-truth", [paper.TRUTH])


def floor_on_synthetic(setup: Setup, done: Done) -> dict[str, float]:
    """What runs at the exact parameters differ by at the states of the synthetic reference, percent; nothing where it is not known."""
    if needs_synthetic(setup):
        return {}
    return floor(done.repeats(at_truth(setup)), setup.synthetic().control, BOTH)


def at_toyoura(setup: Setup, particles: int, pressure: float = PRESSURE) -> Case:
    """Runs at what the paper calibrated on Toyoura sand at 0.5 MPa: by what they differ is the floor of studies on that sand, with so many particles
    and at this pressure in Pa.
    """
    elsewhere = "" if pressure == PRESSURE else f"-{pressure / 1e6:g}MPa"
    own = "" if setup.has_packing(particles) else "-own"
    setting = f"runs of {particles} particles at the paper's calibrated parameters and {pressure / 1e6:g} MPa"
    return runs_at(setup, setting, f"runs-at-toyoura-{particles}{own}{elsewhere}", [paper.TOYOURA], particles=particles, pressure=pressure, own=True)


def proof(setup: Setup) -> Case:
    """The calibrations of the proof of concept, which other studies begin from."""
    return on_synthetic(setup, "mid", 80, setup.short)


def proof_by_posterior(setup: Setup, done: Done) -> Case:
    """The same by the method "posterior"."""
    return on_synthetic_by_posterior(setup, done, "mid", setup.short)
