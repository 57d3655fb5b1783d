"""What speaks against a calibration before it is run: what no test can have measured, and what is possible and yet seldom meant."""

from __future__ import annotations

import numpy as np

from graincal.campaign.asked.calibration import POSTERIOR, Calibration
from graincal.campaign.asked.doubt import Doubt
from graincal.campaign.asked.experiment import Experiment
from graincal.campaign.asked.limits import limit_doubts
from graincal.campaign.asked.place import PARSL
from graincal.campaign.asked.tested import OTHER, Tested
from graincal.campaign.file.strain_doubts import LARGEST, strain_doubts
from graincal.campaign.file.stress_doubts import stress_doubts
from graincal.campaign.file.void_ratio_doubts import void_ratio_doubts
from graincal.data import InputError, Reference
from graincal.execution import available_cores
from graincal.execution.providers import Blocks
from graincal.inference.likelihood.thinning import Thinning
from graincal.inference.posterior.posterior_filter import PosteriorFilter
from graincal.laboratory.backbone import first_movement
from graincal.laboratory.quantities import DIMENSIONS
from graincal.models import CommandModel, PythonModel, StressPathTest
from graincal.models.contact_laws import unusual_parameters
from graincal.models.stress_path import STRAINS, unusual

TURNED = 0.03
"""Of all that the volumetric strain changes by: a dilation at first that is larger, before contraction, is no seating."""


def doubts(calibration: Calibration) -> list[Doubt]:
    """All that speaks against a calibration, as far as its own records tell."""
    said = [doubt for experiment in calibration.experiments for doubt in doubts_of_experiment(experiment)]
    if calibration.method == POSTERIOR and calibration.filter_options.get("packing_scatter", True):
        said += [
            Doubt(
                "simulated-elsewhere",
                "its reference is a simulation, and is taken for one on another packing like this one; where it is of this one, packing_scatter = false under [filter] says so.",
                experiment.name,
            )
            for experiment in calibration.experiments
            if experiment.reference.simulated and experiment.siblings
        ]
    if any(isinstance(experiment.model, StressPathTest) for experiment in calibration.experiments):
        space = calibration.space.of_experiment(0)
        given = {name: (float(low), float(high)) for name, low, high in zip(space.names, space.low, space.high)} | {
            name: (value,) for name, value in space.fixed.items()
        }
        unlikely = unusual_parameters({f"parameters.{name}": values for name, values in given.items()})
        said += [Doubt("unusual-parameter", sentence) for sentence in unlikely]
    said += _unread_parameters(calibration)
    said += limit_doubts(calibration, calibration.blank_filter())
    said += _idle_workers(calibration)
    said += _of_place(calibration)
    if calibration.place is None and calibration.number_of_workers > (cores := available_cores()):
        text = f"{calibration.number_of_workers} workers are more than the {cores} core{'s' * (cores > 1)} that this process may use: evaluations that compute are no faster for it."
        said.append(Doubt("more-workers-than-cores", text))
    return said


def _unread_parameters(calibration: Calibration) -> list[Doubt]:
    """Parameters that no experiment's program is told; other models take all, or refuse what they do not know."""
    programs = [(each.model, each.reference.control) for each in calibration.experiments if isinstance(each.model, CommandModel)]
    if len(programs) < len(calibration.experiments):
        return []
    space = calibration.space.of_experiment(0)
    unread = [*space.names, *space.fixed]
    for model, control in programs:
        unread = [name for name in unread if name in model.unread((*space.names, *space.fixed), control)]
    return [Doubt("key-without-effect", f"the parameter {name} changes nothing: no program is told it.") for name in unread]


def _idle_workers(calibration: Calibration) -> list[Doubt]:
    """Workers that have nothing to do, once the first batch has filled the ranges, or in any iteration of the paper's method."""
    filter, workers = calibration.blank_filter(), calibration.number_of_workers
    if isinstance(filter, PosteriorFilter):
        at_once, of = filter.batch_after(filter.first_batch) * (1 + filter.ahead), "runs that are under way at once after the first batch"
        mend = "a larger batch, or ahead, under [filter] gives them some"
    else:
        at_once, of, mend = filter.samples_per_iteration, "samples of an iteration", "a larger alpha under [filter] gives them some"
    if workers <= at_once:
        return []
    return [Doubt("more-workers-than-runs", f"{workers} workers are more than the {at_once} {of}: {workers - at_once} of them would have no work; {mend}.")]


def _of_place(calibration: Calibration) -> list[Doubt]:
    """What blocks of machines lack here. A function that gives an executor is not called before it is needed."""
    if calibration.place is None or calibration.place.executor != PARSL:
        return []
    try:
        Blocks(**calibration.place.blocks).check()
    except InputError as error:
        return [Doubt("place-not-ready", str(error))]
    return []


def doubts_of_experiment(experiment: Experiment) -> list[Doubt]:
    """What speaks against one experiment."""
    said = doubts_of_reference(Tested.of(experiment), experiment.name)
    if isinstance(experiment.model, StressPathTest):
        said += [Doubt("far-from-quasi-static", sentence, experiment.name) for sentence in unusual(experiment.model)]
    if isinstance(experiment.model, CommandModel):
        said += [Doubt("file-not-linked", sentence, experiment.name) for sentence in map(_not_linked, experiment.model.not_linked)]
    if isinstance(experiment.model, PythonModel) and (text := _too_far(experiment.model, experiment.reference)):
        said.append(Doubt("strain-too-large", text, experiment.name))
    return said


def _not_linked(name: str) -> str:
    return f'command names {name}, which lies beside the calibration file: an evaluation has a folder of its own, and sees it where link = ["{name}"] says so.'


def _too_far(model: PythonModel, reference: Reference) -> str:
    """What is said of a function's own strains that no test reaches; empty for others."""
    last = 0.0 if model.control is None else float(np.max(np.abs(model.control)))
    return (
        f"model.control goes to {last:g}, which no strain reaches: values are fractions, not percent."
        if reference.control_name in STRAINS and last > LARGEST
        else ""
    )


def doubts_of_reference(tested: Tested, experiment: str) -> list[Doubt]:
    """What speaks against a reference, by what is known of its test."""
    found = [
        *_dilates_first(tested),
        *strain_doubts(tested),
        *stress_doubts(tested),
        *void_ratio_doubts(tested),
        *_constant(tested),
        *_large_errors(tested.reference),
    ]
    return [Doubt(doubt.code, doubt.sentence, experiment) for doubt in found]


def thinning_notes(calibration: Calibration) -> list[Doubt]:
    """What was done with dense references."""
    return [
        Doubt(
            "states-put-together",
            f"the likelihood sees the {len(thinning.whole.control)} rows put together to {len(thinning.kept.control)} states, and errors ε are of all rows; "
            "thin = false under [filter] keeps every row.",
            experiment.name,
        )
        for experiment, thinning in zip(calibration.experiments, calibration.blank_filter().thinnings)
        if thinning.thinned
    ]


def _large_errors(reference: Reference) -> list[Doubt]:
    """Measurement errors as large as what was measured: most of them are percent that were meant to be fractions."""
    errors = {name: max(error.absolute, error.step, error.noise) for name, error in reference.measurement_errors.items()} | {
        reference.control_name: reference.control_step
    }
    measured = {name: np.ptp(values) for name, values in reference.observables.items()} | {reference.control_name: np.ptp(reference.control)}
    relative = [
        f"{name} is said to be measured to {error.relative:g} of each value, which is {100 * error.relative:g} %; errors are fractions here, not percent."
        for name, error in reference.measurement_errors.items()
        if error.relative > 0.3
    ]
    absolute = [
        f"{name} is said to be measured to {error:g}, and it varies by {measured[name]:.3g} in all; strains and their errors are fractions here, not percent."
        for name, error in errors.items()
        if error > 0.5 * measured[name] > 0
    ]
    return [Doubt("large-error", sentence) for sentence in (*relative, *absolute)]


def _constant(tested: Tested) -> list[Doubt]:
    """Known quantities that never change, where the test changes them."""
    held = {
        "undrained": ("volumetric_strain", "void_ratio"),
        "constant-mean-stress": ("mean_stress",),
        OTHER: ("volumetric_strain", "void_ratio", "mean_stress"),
    }.get(tested.kind, ())
    return [
        Doubt("constant-observable", f"{name} is {values[0]:.4g} in all {len(values)} rows: was it not measured, or is it another column?")
        for name, values in tested.reference.measured.items()
        if len(values) > 2 and np.ptp(values) == 0 and name in (*DIMENSIONS, "deviatoric_stress", "mean_stress") and name not in held
    ]


def _turn(reference: Reference) -> str:
    """How the reference is read with the other sign."""
    name = "volume_change" if "volume_change" in reference.read_as and "volumetric_strain" not in reference.read_as else "volumetric_strain"
    wanted = "positive" if name in reference.turned else "negative"
    return f'if the file counts contraction as {wanted}, its reference needs compression = {{ {name} = "{wanted}" }}.'


def _dilates_first(tested: Tested) -> list[Doubt]:
    """That the volumetric strain looks turned. A very dense sample may dilate from its first state on: then its stress ratio has a peak, if the test goes as far as that."""
    # Single rows of a logger tell by their noise.
    reference = Thinning.of(tested.reference).kept
    volumetric_strain = reference.measured.get("volumetric_strain")
    if tested.undrained or reference.control_name != "axial_strain" or volumetric_strain is None or first_movement(volumetric_strain) >= 0:
        return []
    text = "the volumetric strain says that the sample dilates first, and a drained sample normally contracts first; " + _turn(tested.reference)
    whole, lowest = np.ptp(volumetric_strain), volumetric_strain.min()
    if volumetric_strain[-1] - lowest > 0.1 * whole:
        return [Doubt("dilates-first" if volumetric_strain[0] - lowest > TURNED * whole else "dilates-at-first", text)]
    stress_ratio = reference.measured.get("stress_ratio")
    has_peak = stress_ratio is not None and stress_ratio.max() - stress_ratio[-1] > 0.05 * np.ptp(stress_ratio)
    return [] if has_peak else [Doubt("dilates-at-first", text)]
