"""The cases that several studies share: by the same names they are the same work."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Sequence
from dataclasses import replace

from graincal.campaign import Calibration
from graincal.studies import forecast, paper
from graincal.studies.settings import Setup, space
from graincal.studies.study import Case, Done, calibrations
from graincal.studies.work import Running

SYNTHETIC_PARTICLES, PRESSURE = 2000, 0.5e6


def on_synthetic(setup: Setup, box: str, samples: int, seeds: Iterable[int], iterations: int = forecast.ITERATIONS, most_iterations: int = paper.MOST_ITERATIONS, recorded: tuple[str, ...] = ()) -> Case:
    """The paper's method on the synthetic reference."""

    def make(seed: int):
        reference = setup.synthetic(recorded)
        return setup.by_the_paper(setup.test(SYNTHETIC_PARTICLES, PRESSURE), reference, seed=seed, samples=samples, box=box, most_iterations=most_iterations)

    alpha = round(samples / 8.05)
    only = "-stress-only" if recorded else ""
    return calibrations(f"{box}, α = {alpha}", f"synthetic-{box.replace(' ', '-')}-alpha-{alpha}{only}", make, seeds, forecast.by_the_paper(setup, SYNTHETIC_PARTICLES, box, samples, iterations), needs_synthetic(setup))


def on_synthetic_by_posterior(setup: Setup, done: Done, box: str, seeds: Iterable[int], recorded: tuple[str, ...] = ()) -> Case:
    """The method "posterior" on the synthetic reference, a run on the packing itself. Any but that of both observables and the mid range learns from the runs of that one's first seed, for they are of the same model."""

    def make(seed: int) -> Calibration:
        reference = setup.synthetic(recorded)
        return setup.by_the_posterior(setup.test(SYNTHETIC_PARTICLES, PRESSURE), reference, seed=seed, box=box, same_packing=True)

    only, alone = "-stress-only" if recorded else "", box == "mid" and not recorded
    size = forecast.by_the_posterior(setup, SYNTHETIC_PARTICLES, box, with_runs=not alone)
    case = calibrations(f"{box}, posterior", f"synthetic-{box.replace(' ', '-')}-posterior{only}", make, seeds, size, needs_synthetic(setup))
    if case.missing or alone:
        return case
    first = on_synthetic_by_posterior(setup, done, "mid", [1]).work[0]
    return Case(case.setting, tuple(replace(each, runs_of=done.folder_of(first)) for each in case.work), after=(first,))


def needs_synthetic(setup: Setup) -> str:
    """What the synthetic studies lack."""
    return setup.missing("synthetic_reference.csv", SYNTHETIC_PARTICLES)


def runs_at(
    setup: Setup,
    setting: str,
    name: str,
    theta: Sequence[tuple[float, ...]] | Callable[[], Sequence[Sequence[float]]],
    *,
    count: int | None = None,
    particles: int = SYNTHETIC_PARTICLES,
    pressure: float = PRESSURE,
    times: int | None = None,
    own: bool = False,
) -> Case:
    """Plain runs at parameters, or at those that are known once other work was run; `count` says then how many."""
    if missing := setup.missing(None, None if own else particles):
        return Case(setting, missing=missing)
    called, number, each = (theta, count, times) if callable(theta) else (lambda: theta, len(theta), times)
    each = each or setup.size.repeats
    return Case(setting, (Running(name, setting, forecast.runs(setup, particles, number * each), lambda: setup.test(particles, pressure, own), called, each, space("extra wide")),))


def at_truth(setup: Setup) -> Case:
    """Runs at the exact parameters of the synthetic reference: by what they differ is the floor of all studies on it, and their fabric is what others are compared with."""
    return runs_at(setup, "runs at the exact parameters", "runs-at-truth", [paper.TRUTH])


def proof(setup: Setup) -> Case:
    """The calibrations of the proof of concept, which other studies begin from."""
    return on_synthetic(setup, "mid", 80, setup.short)
