"""Runs of other campaigns and of libraries, for a calibration of the same models to learn from."""

from __future__ import annotations

import shlex
from collections.abc import Mapping, Sequence
from contextlib import closing
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from graincal.campaign.asked.calibration import Calibration
from graincal.campaign.asked.description import describe_model
from graincal.campaign.asked.experiment import Experiment
from graincal.campaign.found.replay import INFEASIBLE
from graincal.campaign.stored.asked import as_stored
from graincal.campaign.stored.store import Store
from graincal.data import Failure, InputError, Response, Samples
from graincal.inference.driving.known_runs import KnownRuns
from graincal.inference.likelihood.thinning import Thinning
from graincal.models import Model, StressPathTest
from graincal.models.proportion import in_units_of
from graincal.notation.numbers import pressure

# Of a model that was run and one that is to be: the pressure may be another one, where the test is the same in units of it; what is unknown in one may be fixed in the other; and a program may run under other limits.
_MAY_DIFFER = ("confining_pressure", "fixed", "running")

_NAMES = {"name": "the function", "more_packings": "the number of packings", "turns": "turns in units of the confining pressure"}
"""Of keys of a described model whose own names do not say what they are: words that do."""

SAME = 1e-9
"""Values of one parameter that differ by less than this part of its range are the same."""


@dataclass
class Gathered:
    """Runs as they are found, each with its parameters (n,) and a response (K, J) for each experiment, or none."""

    theta: list[NDArray[np.float64]] = field(default_factory=list)
    responses: list[list[NDArray[np.float64]]] = field(default_factory=list)
    infeasible: list[bool] = field(default_factory=list)
    missing: list[bool] = field(default_factory=list)
    known: set[tuple[bytes, ...]] = field(default_factory=set)

    def known_runs(self, calibration: Calibration, thinnings: Sequence[Thinning], said: Sequence[str]) -> KnownRuns:
        """All of them, with what is said of where they are from."""
        shapes = [thinning.kept.values.shape for thinning in thinnings]
        responses = tuple(np.array([each[number] for each in self.responses]).reshape(-1, *shape) for number, shape in enumerate(shapes))
        theta, infeasible, missing = np.array(self.theta), np.array(self.infeasible), np.array(self.missing)
        return KnownRuns(theta.reshape(-1, calibration.space.size), responses, infeasible.astype(bool), missing.astype(bool), tuple(said))


def known_runs(folders: Sequence[str | Path], calibration: Calibration) -> KnownRuns:
    """The runs in the folders of campaigns and libraries that a calibration can learn from.

    A run counts that was made on the same packings by the same law along the same path with the same settings, at parameters that the calibration's prior holds possible, and covers its references. The reference
    that it was made for does not matter. A triaxial test whose grains' density follows from the inertial number is the same in units of its confining pressure, and so serves at any:
    a run at another pressure is one at a log_E as much higher. Functions of Python are compared by their names, which is said. Raises InputError, with the difference by name, for a folder whose models are others or that has no run to learn from.
    """
    thinnings = calibration.blank_filter().thinnings
    gathered, said = Gathered(), []
    resolved = [Path(folder).resolve() for folder in folders]
    if twice := [folder for folder in dict.fromkeys(resolved) if resolved.count(folder) > 1]:
        raise InputError(f"{twice[0]}: this folder is named twice.")
    for folder in folders:
        before = len(gathered.theta)
        with closing(Store.open(Path(folder))) as store:
            left_out, by_name = _gather(gathered, store, str(folder), calibration, thinnings), _by_name(store)
            scaled = _scaled(store, str(folder), calibration)
        found = len(gathered.theta) - before
        if not found:
            raise InputError(f"{folder}: none of its runs can be learnt from, {listed(left_out) or 'for it has none that has ended'}.")
        failed = sum(gathered.missing[before:]) + sum(gathered.infeasible[before:])
        but = f"; left out: {listed(left_out)}" if left_out else ""
        same = f" That its model is the same is known by its name alone, {by_name}." if by_name else ""
        said.append(f"Learns from {found} runs of {folder}{f', of which {failed} failed' if failed else ''}{but}.{scaled}{same}")
    return gathered.known_runs(calibration, thinnings, said)


def _by_name(store: Store) -> str:
    """The names of the functions and the commands that a store's models are; nothing for built-in tests. Raises InputError for one that has no name of its own."""
    models = [each["model"] for each in store.description["experiments"]]
    named = dict.fromkeys(model.get("function") or model.get("name") for model in models if model["kind"] in ("python", "absent"))
    programs = dict.fromkeys(shlex.join(model["command"]) for model in models if "command" in model)
    if nameless := [name for name in named if "<" in name]:
        raise InputError(
            f"{store.folder}: its model is {nameless[0]}, which has no name by which it could be known to be the same; a function or a class of a module was expected."
        )
    return ", ".join((*named, *programs))


def _gather(gathered: Gathered, store: Store, named: str, calibration: Calibration, thinnings: Sequence[Thinning]) -> dict[str, int]:
    """Add the runs of one store; how many were left out, by the reason."""
    left_out: dict[str, int] = {}
    samples, scale = store.all_samples(), [_scales(experiment.model) for experiment in calibration.experiments]
    for numbers in _same_models(store, named, calibration):
        theta, outside = _parameters(store, numbers, samples, calibration)
        outcomes = list(zip(*(store.outcomes(samples.ids, number) for number in numbers)))
        for row in range(len(samples)):
            if outside[row]:
                left_out[outside[row]] = left_out.get(outside[row], 0) + 1
                continue
            reason = add_run(gathered, theta[row], outcomes[row], calibration.experiments, thinnings, scale)
            if reason:
                left_out[reason] = left_out.get(reason, 0) + 1
    return left_out


def add_run(
    gathered: Gathered,
    theta: NDArray[np.float64],
    outcomes: Sequence[Response | Failure | None],
    experiments: Sequence[Experiment],
    thinnings: Sequence[Thinning],
    scale: Sequence[bool],
) -> str | None:
    """Add one run; or why it says nothing. scale: whether each experiment's response is to be taken to its confining pressure."""
    failures = [outcome for outcome in outcomes if isinstance(outcome, Failure)]
    nothing = [np.full(thinning.kept.values.shape, np.nan) for thinning in thinnings]
    if any(failure.kind in ("output", "incomplete") for failure in failures):
        # What could not be compared with the reference of then.
        return "whose output could not be used"
    if failures:
        impossible = any(failure.kind == INFEASIBLE for failure in failures)
        responses = nothing
    elif len(ended := [outcome for outcome in outcomes if isinstance(outcome, Response)]) < len(outcomes):
        return "not run to their end"
    elif any(outcome.stopped for outcome in ended):
        return "stopped early"
    else:
        impossible, responses = False, []
        for outcome, experiment, thinning, scaled in zip(ended, experiments, thinnings, scale):
            at_its_pressure = outcome.at_pressure(pressure_of(experiment.model)) if scaled else outcome
            if not set(experiment.reference.names) <= set(outcome.values):
                return f"without {', '.join(sorted(set(experiment.reference.names) - set(outcome.values)))}"
            if isinstance(compared := experiment.usable(at_its_pressure), Failure):
                return "shorter than a reference" if "covers" in compared.reason else "not finite at a reference's rows"
            responses.append(thinning.reduce(experiment.observables(at_its_pressure)[None])[0])
    run = (theta.tobytes(), *(each.tobytes() for each in responses))
    if run in gathered.known:
        return "known from another folder"
    gathered.known.add(run)
    gathered.theta.append(theta)
    gathered.responses.append(responses)
    gathered.infeasible.append(bool(failures) and impossible)
    gathered.missing.append(bool(failures) and not impossible)
    return None


def pressure_of(model: Model) -> float:
    """The confining pressure of a test whose responses scale with it, Pa."""
    assert isinstance(model, StressPathTest), "only these scale"
    return model.confining_pressure


def _scales(model: object) -> bool:
    return isinstance(model, StressPathTest) and _in_units_of_pressure(describe_model(model))


def _scaled(store: Store, named: str, calibration: Calibration) -> str:
    """A sentence on runs that are taken to other pressures than their own; nothing where none is."""
    theirs, taken = store.calibration.experiments, set()
    for numbers in _same_models(store, named, calibration):
        pairs = [(experiment.model, theirs[other].model) for experiment, other in zip(calibration.experiments, numbers)]
        taken |= {(pressure(pressure_of(other)), pressure(pressure_of(own))) for own, other in pairs if _scales(own) and pressure_of(own) != pressure_of(other)}
    if not taken:
        return ""
    said = ", ".join(f"{other} to {own}" for other, own in sorted(taken))
    return f" Runs are taken from {said}, where the same curve has a log_E that differs by the logarithm of the pressures' ratio."


def _same_models(store: Store, named: str, calibration: Calibration) -> list[tuple[int, ...]]:
    """For each way in which the store's experiments serve the calibration's, the number of the one that serves each. Raises InputError where there is none."""
    theirs = [each["model"] for each in store.description["experiments"]]
    ours = [as_stored(describe_model(experiment.model)) for experiment in calibration.experiments]
    serve = [[number for number, each in enumerate(theirs) if not _differences(each, model)] for model in ours]
    for experiment, model, numbers in zip(calibration.experiments, ours, serve):
        if not numbers:
            # What the nearest of them differs by.
            named_differences = min((_differences(each, model) for each in theirs), key=len)
            raise InputError(
                f'{named}: its runs are of other models than the experiment "{experiment.name}", they differ in {", ".join(named_differences)}; runs of the same settings were expected. '
                "Runs of other settings can serve as a first look: first_look under [filter]."
            )
    if len(serve) == 1:
        return [(number,) for number in serve[0]]
    # Of several experiments a run is one of all, at one place: each by the one at its own pressure.
    chosen = []
    for experiment, model, numbers in zip(calibration.experiments, ours, serve):
        at_pressure = [number for number in numbers if theirs[number].get("confining_pressure") == model.get("confining_pressure") and number not in chosen]
        if not at_pressure:
            raise InputError(
                f'{named}: it has no runs at the confining pressure of the experiment "{experiment.name}", and with several experiments those of each, at its own pressure, were expected.'
            )
        chosen.append(at_pressure[0])
    return [tuple(chosen)]


def _differences(one: Mapping[str, Any], other: Mapping[str, Any]) -> list[str]:
    """The settings by which two models, as they are described, differ so that runs of one are none of the other."""
    if one["kind"] != other["kind"]:
        return ["the kind of the model"]
    keys = sorted((one.keys() | other.keys()) - set(_MAY_DIFFER))
    different = [_NAMES.get(key, key) for key in keys if not _equal(key, _setting(one, key), _setting(other, key))]
    if one.get("confining_pressure") != other.get("confining_pressure") and not (_in_units_of_pressure(one) and _in_units_of_pressure(other)):
        different.append("confining_pressure")
    return different


def _in_units_of_pressure(model: Mapping[str, Any]) -> bool:
    """Whether a test, as it is described, is the same in units of its confining pressure: its grains' density follows from the inertial number."""
    return "inertial_number" in model and "table" not in model


def _setting(model: Mapping[str, Any], key: str) -> Any:
    """A setting of a model, as it is described; stresses at which its path turns around are in units of its confining pressure, in which it is the same."""
    value = model.get(key)
    return in_units_of(model["confining_pressure"], value).tolist() if key == "turns" and value else value


def _equal(key: str, one: Any, other: Any) -> bool:
    if key in ("packing", "more_packings"):
        # By what they are, not by the file that they were read from.
        return _without_names(one) == _without_names(other)
    return one == other


def _without_names(packing: Any) -> Any:
    if isinstance(packing, list):
        return [_without_names(each) for each in packing]
    return {key: value for key, value in packing.items() if key != "name"} if isinstance(packing, Mapping) else packing


def _parameters(store: Store, numbers: Sequence[int], samples: Samples, calibration: Calibration) -> tuple[NDArray[np.float64], list[str]]:
    """The samples' parameters as the calibration has them, (N, n), and of each why it cannot be used, "" where it can."""
    theirs, space = store.calibration, calibration.space
    theta, reasons = np.full((len(samples), space.size), np.nan), [""] * len(samples)
    for number, (experiment, other) in enumerate(zip(calibration.experiments, numbers)):
        seen = theirs.space.seen_by(other, samples)
        values = {name: seen.theta[:, column] for column, name in enumerate(seen.names)}
        values |= {name: np.full(len(samples), value) for name, value in getattr(theirs.experiments[other].model, "fixed", {}).items()}
        if _scales(experiment.model):
            values["log_E"] = values["log_E"] + np.log10(pressure_of(experiment.model) / pressure_of(theirs.experiments[other].model))
        own = space.of_experiment(number)
        # As far as values that differ by less than SAME are the same.
        ends = [own.moved(own.low, np.full(own.size, -SAME)), own.low, own.high, own.moved(own.high, np.full(own.size, SAME))]
        wanted = {name: tuple(map(float, each)) for name, *each in zip(own.names, *ends)}
        if missing := sorted(wanted.keys() - values.keys()):
            raise InputError(f"{store.folder}: its runs have no {', '.join(missing)}, and {', '.join(own.names)} were expected.")
        fixed = {**getattr(experiment.model, "fixed", {}), **own.fixed}
        for name, known in values.items():
            if name in wanted:
                lowest, low, high, highest = wanted[name]
                wrong = (known < lowest) | (known > highest)
                known, reason = np.clip(known, low, high), f"at {name} outside {low:g} to {high:g}"
            elif name in fixed:
                wrong, reason = ~np.isclose(known, fixed[name], rtol=1e-9, atol=1e-12), f"at another {name} than {fixed[name]:g}"
            else:
                raise InputError(f"{store.folder}: its runs have {name}, which is none of the calibration's parameters.")
            reasons = [before or (reason if bad else "") for before, bad in zip(reasons, wrong)]
            for column in (k for k, (each, which) in enumerate(zip(space.parameters, space.experiments)) if each == name and which in (None, number)):
                apart = np.isfinite(theta[:, column]) & ~np.isclose(theta[:, column], known, rtol=1e-9, atol=1e-12)
                reasons = [before or (f"at several values of {name}" if bad else "") for before, bad in zip(reasons, apart)]
                theta[:, column] = known
    for constraint in space.constraints:
        reasons = [before or ("" if met else f"where {constraint.source} does not hold") for before, met in zip(reasons, constraint.holds(theta))]
    return theta, reasons


def listed(left_out: Mapping[str, int]) -> str:
    return ", ".join(f"{count} {reason}" for reason, count in left_out.items())
