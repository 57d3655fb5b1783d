"""What a calibration is asked to do."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field, fields, replace
from numbers import Real
from types import MappingProxyType
from typing import Any, Literal

import numpy as np

from graincal.campaign.asked.experiment import Experiment
from graincal.campaign.asked.file_names import file_name
from graincal.campaign.asked.place import PARSL, Place
from graincal.data import InputError, ParameterSpace, Reference, Samples
from graincal.execution import number_of_workers
from graincal.inference import DEFAULT_METHOD, METHODS, IterativeBayesianFilter, PosteriorFilter, Stop
from graincal.inference.driving.known_runs import KnownRuns
from graincal.inference.likelihood.error_model import ErrorOptions
from graincal.inference.likelihood.packings import Siblings
from graincal.inference.posterior.emulation import Found
from graincal.inference.posterior.first_look import FirstLook
from graincal.inference.posterior.knowledge import Knowledge
from graincal.inference.posterior.posterior_filter import FIRST_PER_PARAMETER
from graincal.inference.sampling.samples import halton
from graincal.laboratory.vocabulary import did_you_mean_observable
from graincal.models import ByHandModel, Model, StressPathTest
from graincal.models.contact_laws import check_ranges, check_units
from graincal.notation.printable import MOST, is_printable, printable
from graincal.suggestion import did_you_mean

POSTERIOR = "posterior"

NO_SPACE = "a calibration needs a parameter space: space = ParameterSpace({name: (low, high), ...})."


def round_of(method: str) -> str:
    """What a method calls the samples that it asks for at once, and the update that follows."""
    return "batch" if method == POSTERIOR else "iteration"


_OF_THE_PAPER = ("alpha", "effective_sample_size", "scale", "covariance", "thin")
FILTER_OPTIONS = dict.fromkeys(METHODS, _OF_THE_PAPER) | {
    POSTERIOR: ("first_batch", "batch", "ahead", "early_stop", "thin", "correlation_length", "discrepancy", "packing_scatter")
}
"""The options of each method's filter."""

FILLING, MOST_FILLING = 1e10, 60
"""Particle-steps of the built-in engine that fill the ranges before anything is learnt, some minutes on two cores; and the most runs, times the number of parameters."""

FILLING_SECONDS = 600.0
"""The same of other models whose runs are said to take some seconds: on one core."""

LIMITS = ("max_iterations", "max_evaluations", "hours")
"""The criteria of stopping that say how long a campaign may be, and nothing of its answer."""
CRITERIA = dict.fromkeys(METHODS, ("s", "gl_error_increment", "error", "error_increment", *LIMITS)) | {POSTERIOR: ("posterior_shift", *LIMITS)}
"""The criteria of stopping that each method looks at."""

Filter = IterativeBayesianFilter | PosteriorFilter


@dataclass(frozen=True, eq=False)
class Calibration:
    """The unknowns, the experiments and the method: everything that determines what a campaign finds.

    space: the unknowns, those parameters told apart that have a value of their own in each experiment, whether they were when it was given or not.
    filter_options: those of the filter that are not left at its defaults. workers: evaluations at once, "all" for one a core; it changes nothing of
    what is found. source: the text of the calibration file, if there is one. truth: parameters whose values are known, as those of a synthetic reference;
    nothing is found by them, and the report shows them beside what is; of a parameter with a value for each experiment, either all or one of them. file: the path of the calibration file from the root, if there is one.
    first_look: evaluations of cheaper models to begin with, by the method "posterior". look: the calibration by cheaper models that makes them, which is run
    first where they are not there yet. known: runs of the same models that were made before (`runs.known_runs`), by the method "posterior".
    expected_seconds: what one evaluation is said to take on one core, in all experiments: so a method knows whether hundreds may fill the ranges, or every one counts.
    place: where evaluations run, if not in workers of graincal's own; it changes nothing of what is found either.
    by_hand: whether somebody makes all runs elsewhere, whatever the models are, and tells what they gave. Like `workers`, it changes nothing of what is found.
    """

    space: ParameterSpace
    experiments: Sequence[Experiment]
    method: str = DEFAULT_METHOD
    filter_options: Mapping[str, Any] = field(default_factory=dict)
    stop: Stop = Stop()
    seed: int = 1
    workers: int | Literal["all"] = "all"
    source: str = ""
    truth: Mapping[str, float] = field(default_factory=dict)
    file: str = ""
    first_look: FirstLook | None = None
    look: Calibration | None = None
    known: KnownRuns | None = None
    expected_seconds: float | None = None
    place: Place | None = None
    by_hand: bool = False

    def __post_init__(self) -> None:
        object.__setattr__(self, "experiments", tuple(self.experiments))
        object.__setattr__(self, "filter_options", MappingProxyType(dict(self.filter_options)))
        if isinstance(self.space, ParameterSpace):
            object.__setattr__(self, "space", self.space.for_experiments([experiment.name for experiment in self.experiments]))
            object.__setattr__(self, "truth", _truth_of_unknowns(self.space, self.truth))
        object.__setattr__(self, "truth", MappingProxyType(dict(self.truth)))

    @property
    def decided_options(self) -> dict[str, Any]:
        """Those of the filter, and what is decided once for a calibration: how many runs fill the ranges."""
        options = dict(self.filter_options)
        if self.method == POSTERIOR and "first_batch" not in options and (count := self._filling()):
            options["first_batch"] = count
        return options

    def _filling(self) -> int | None:
        """How many runs fill the ranges first, by what they cost in particle-steps and by no clock: for the built-in engine. For others by the seconds that they are said to take; None for the
        filter's own number, where every run counts."""
        if not isinstance(self.space, ParameterSpace) or not all(isinstance(each, Experiment) for each in self.experiments) or self.first_look or self.look:
            return None
        n, most = self.space.size, self.stop.max_evaluations
        work = FILLING_SECONDS / self.expected_seconds if self.expected_seconds else self._filling_of_the_engine()
        if work is None:
            return None
        few = FIRST_PER_PARAMETER * n
        count = int(np.clip(work, few, MOST_FILLING * n))
        return count if most is False else int(np.clip(count, few, max(few, most // 3)))

    def _filling_of_the_engine(self) -> float | None:
        """How many of the built-in engine's runs are FILLING particle-steps; None for other models."""
        n = self.space.size
        try:
            theta = self.space.from_unit(np.linspace(0, 1, 21)[:, None] * np.ones(n))
            if self.space.constraints:
                theta = halton(self.space, len(theta), np.random.default_rng(0))
            samples = Samples(np.arange(len(theta)), theta, self.space.names)
            costs = [experiment.expected_particle_steps(self.space.seen_by(number, samples)) for number, experiment in enumerate(self.experiments)]
        except InputError:
            # What is wrong with it `check` says.
            return None
        known = [cost for cost in costs if cost is not None]
        return None if len(known) < len(costs) or not costs else float(FILLING / np.mean(known, axis=1).sum())

    def check(self) -> Calibration:
        """Raise InputError for what cannot be calibrated, before anything is evaluated; the calibration itself otherwise."""
        if not isinstance(self.space, ParameterSpace):
            raise InputError(NO_SPACE)
        names = [experiment.name for experiment in self.experiments]
        if not names:
            raise InputError("a calibration needs at least one experiment.")
        if len({file_name(name) for name in names}) < len(names):
            raise InputError(f"experiments must have different names, by letters and digits, not {', '.join(names)}.")
        if self.method not in METHODS:
            raise InputError(f'method must be one of {", ".join(METHODS)}, not "{self.method}"{did_you_mean(self.method, METHODS)}.')
        self._check_options()
        for name, value in self.truth.items():
            if name not in self.space.names:
                known = tuple(dict.fromkeys((*self.space.of_experiment(0).names, *self.space.names)))
                raise InputError(f"truth.{name} is not a parameter{did_you_mean(name, known)}; expected some of {', '.join(known)}.")
            if not (isinstance(value, Real) and np.isfinite(value)):
                raise InputError(f"truth.{name} must be a number, not {value!r}.")
        seconds = self.expected_seconds
        if seconds is not None and (isinstance(seconds, bool) or not isinstance(seconds, Real) or not 0 < seconds < np.inf):
            raise InputError(f"run.expected_seconds must be a number of seconds above 0, not {seconds!r}.")
        number_of_workers(self.workers)  # raises for what is none
        self._check_place()
        for experiment in self.experiments:
            if len(experiment.reference.control) < 2:
                raise InputError(f'experiment "{experiment.name}": its reference holds a single state, and a curve of at least two was expected.')
        self.blank_filter()
        if self.look is not None:
            self._check_look(self.look)
        for number, experiment in enumerate(self.experiments):
            self._check_model(experiment, self.space.of_experiment(number))
        return self

    def _check_place(self) -> None:
        """Raise InputError for what would be another thing elsewhere than on this machine."""
        if self.place is None:
            return
        if self.filter_options.get("early_stop"):
            raise InputError(
                f"filter.early_stop must be false where evaluations run by {self.place}: a run there cannot be watched, and would go on to another end than on this machine."
            )
        if self.place.executor != PARSL and (timed := [each.name for each in self.experiments if getattr(each.model, "timeout", None) is not None]):
            raise InputError(
                f'experiment "{timed[0]}": its model has a timeout, which {self.place} cannot keep; none was expected, or run.executor = "{PARSL}".'
            )

    def check_names(self) -> None:
        """Raise InputError for a name or a unit that cannot be shown as it is. One that was begun before may have some."""
        given = {
            "experiment": [each.name for each in self.experiments],
            "parameter": (*self.space.names, *self.space.fixed),
            "unit": [unit for unit in (*self.space.units, *self.space.units_of_fixed.values()) if unit],
        }
        given["quantity"] = [name for each in self.experiments for name in (each.reference.control_name, *each.reference.measured)]
        for what, names in given.items():
            if wrong := [name for name in names if not (isinstance(name, str) and is_printable(name, MOST))]:
                raise InputError(
                    f'the name of {"an" if what == "experiment" else "a"} {what} must be printable text of at most {MOST} characters, not "{printable(wrong[0], 60)}".'
                )

    def new_filter(self, looks: Callable[[int], Found | None] | None = None) -> Filter:
        """The filter before its first sample. looks: what was found by looks at so many evaluations, by the method "posterior"."""
        options = {"first_look": self.first_look, "looks": looks} if self.method == POSTERIOR else {}
        return self._filter(**options)

    def new_knowledge(self) -> Knowledge:
        """What is known before the first evaluation, by the method "posterior"."""
        options = {name: self.filter_options[name] for name in ("thin", *self.error_options) if name in self.filter_options}
        return Knowledge(self.space, self._references, siblings=self._siblings, first_look=self.first_look, known=self.known, **options)

    def blank_filter(self) -> Filter:
        """The filter as it would be without its first look, from which it takes seconds to learn: for its settings."""
        return self._filter()

    def _filter(self, **options: Any) -> Filter:
        options |= self.decided_options
        options.pop("packing_scatter", None)
        if self.method == POSTERIOR:
            options |= {"siblings": self._siblings, "known": self.known}
        return METHODS[self.method](self.space, self._references, stop=self.stop, seed=self.seed, **options)

    @property
    def _references(self) -> list[Reference]:
        return [experiment.reference for experiment in self.experiments]

    @property
    def _siblings(self) -> list[Siblings | None] | None:
        """How each experiment's model can be run on packings like its own; None where what packings differ by does not count."""
        if not self.filter_options.get("packing_scatter", True):
            return None
        each = [experiment.siblings for experiment in self.experiments]
        models = [experiment.model for experiment in self.experiments]
        on = [[packing.positions.tobytes() for packing in model.packings] if isinstance(model, StressPathTest) else None for model in models]
        # Experiments without a parameter in common are calibrations by themselves.
        together = any(number is None for number in self.space.experiments)
        return [replace(known, shared=on.count(packings) if together else 1) if known else None for known, packings in zip(each, on)]

    @property
    def error_options(self) -> ErrorOptions:
        """What is taken for granted of the references' errors, as options of `error_model`: those of the method "posterior", and its defaults by others."""
        return {"correlation_length": self.filter_options.get("correlation_length"), "discrepancy": self.filter_options.get("discrepancy")}

    def is_by_hand(self, experiment: int) -> bool:
        """Whether somebody makes the runs of an experiment, by its number, elsewhere, and tells what they gave."""
        return self.by_hand or isinstance(self.experiments[experiment].model, ByHandModel)

    @property
    def number_of_workers(self) -> int:
        """The evaluations that may run at once."""
        return number_of_workers(self.workers)

    def _check_options(self) -> None:
        """Raise InputError for options and criteria that the method does not look at."""
        options, this = FILTER_OPTIONS[self.method], _named(self.method)
        if (self.first_look is not None or self.look is not None) and self.method != POSTERIOR:
            raise InputError(
                f'{"filter.first_look" if self.look is None else "first_look"} is an option of method = "{POSTERIOR}", and with {this} one of {", ".join(options)} was expected.'
            )
        if self.known is not None and self.method != POSTERIOR:
            raise InputError(f'filter.runs is an option of method = "{POSTERIOR}", and with {this} one of {", ".join(options)} was expected.')
        for name in sorted(set(self.filter_options) - set(options)):
            if others := [method for method in METHODS if name in FILTER_OPTIONS[method]]:
                raise InputError(f'filter.{name} is an option of method = "{others[0]}", and with {this} one of {", ".join(options)} was expected.')
            raise InputError(f"filter.{name} is not an option of the filter{did_you_mean(name, options)}; expected one of {', '.join(options)}.")
        refuse_criteria(self.method, {each.name: limit for each in fields(Stop) if (limit := getattr(self.stop, each.name)) != each.default})

    def _check_look(self, look: Calibration) -> None:
        try:
            look.check()
        except InputError as error:
            raise InputError(f"first_look: {error}") from error

    def _check_model(self, experiment: Experiment, space: ParameterSpace) -> None:
        control, model = experiment.reference.control_name, experiment.model
        if isinstance(model, StressPathTest):
            if control != model.control:
                raise InputError(
                    f'experiment "{experiment.name}": {model.name_with_article} is driven by {model.control}, and its reference\'s control is {control}.'
                )
        if model.law:
            check_units(space, model.law)
            check_ranges(space, model.law)
        try:
            check_observables(model, tuple(experiment.reference.measured))
        except InputError as error:
            raise InputError(f'experiment "{experiment.name}": {error}') from error
        if self.by_hand:
            # Nothing is run here, and a model that was handed over in Python is not needed.
            return
        # A model that is given no samples says what is wrong with everything else.
        nothing = space.seen_by(0, Samples(np.zeros(0, dtype=np.int64), np.zeros((0, space.size)), space.names))
        try:
            model.check(experiment.reference.control, nothing)
        except InputError as error:
            raise InputError(f'experiment "{experiment.name}": {error}') from error


def refuse_criteria(method: str, limits: Mapping[str, Any]) -> None:
    """Raise InputError for criteria of stopping, set to these limits, that the method does not look at."""
    for name, limit in limits.items():
        if name not in CRITERIA[method] and limit is not False:
            other = next(other for other in METHODS if name in CRITERIA[other])
            raise InputError(f'stop.{name} is a criterion of method = "{other}", and {_named(method)} looks at {", ".join(CRITERIA[method])}.')


def _named(method: str) -> str:
    """A method for the middle of a sentence; whoever says none should not wonder where it comes from."""
    return f'"{method}", the default,' if method == DEFAULT_METHOD else f'"{method}"'


def _truth_of_unknowns(space: ParameterSpace, truth: Mapping[str, float]) -> dict[str, float]:
    """The truth by unknowns: that of a parameter is the truth of each of its values, where that one has none of its own."""
    whole = set(space.parameters) - set(space.names)
    of_each = {name: truth[parameter] for name, parameter in zip(space.names, space.parameters) if parameter in truth}
    return of_each | {name: value for name, value in truth.items() if name not in whole}


def check_observables(model: Model, names: Sequence[str]) -> None:
    """Raise InputError for names that a model, which says what it returns, does not."""
    returned: Sequence[str] | None = getattr(model, "returned", None)
    for name in names:
        if returned is not None and name not in returned:
            called = model.name_with_article if isinstance(model, StressPathTest) else "the model"
            raise InputError(f"{name} is not an observable of {called}{did_you_mean_observable(name, returned)}, which gives {', '.join(returned)}.")
