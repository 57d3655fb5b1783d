"""A first look: what a campaign of cheaper models on the same experiments found, for another campaign to begin with."""

from __future__ import annotations

from pathlib import Path

import numpy as np

from graincal.campaign.asked.calibration import Calibration
from graincal.campaign.found.record import Record
from graincal.data import InputError, Response
from graincal.inference.posterior.first_look import FirstLook
from graincal.interpolation import span


def first_look_of(result: Record, calibration: Calibration, named: str) -> FirstLook:
    """The evaluations of a campaign that have responses in every experiment. named: how the campaign is called in a mistake.

    Raises InputError for a campaign of other parameters or experiments than the calibration's: both by their names, and experiments by their observables,
    too; and where its responses do not cover the references. Ranges, errors, models and states may differ.
    """
    if set(result.space.names) != set(calibration.space.names):
        raise InputError(
            f"{named}: a first look at {', '.join(calibration.space.names)} was expected, and this campaign is of {', '.join(result.space.names)}."
        )
    columns = [result.space.names.index(name) for name in calibration.space.names]
    known = {experiment.name: number for number, experiment in enumerate(result.experiments)}
    ids, responses = result.ids[result.complete], []
    if not len(ids):
        raise InputError(f"{named}: none of its {result.evaluations} evaluations has a response in every experiment, and some were expected to begin with.")
    thinnings = calibration.blank_filter().thinnings
    for experiment, thinning in zip(calibration.experiments, thinnings):
        reference = experiment.reference
        if experiment.name not in known:
            raise InputError(f'{named}: a first look at the experiment "{experiment.name}" was expected, and this campaign has {", ".join(known)}.')
        other = result.experiments[known[experiment.name]].reference
        if set(other.names) != set(reference.names):
            raise InputError(
                f'{named}: its experiment "{experiment.name}" has the observables {", ".join(other.names)}, and {", ".join(reference.names)} were expected.'
            )
        if other.control_name != reference.control_name:
            raise InputError(f'{named}: its experiment "{experiment.name}" is over {other.control_name}, and {reference.control_name} was expected.')
        outcomes = [result.response(int(id), known[experiment.name]) for id in ids]
        whole = np.array([experiment.observables(outcome) for outcome in outcomes if isinstance(outcome, Response)])
        if not np.isfinite(whole).all():
            raise InputError(
                f'{named}: its experiment "{experiment.name}" covers other states, and the {reference.control_name} of the reference, {span(reference.control)}, was expected.'
            )
        responses.append(thinning.reduce(whole))
    look = FirstLook(result.samples[result.complete][:, columns], tuple(responses))
    try:
        look.check(calibration.space, [thinning.kept for thinning in thinnings])
    except InputError as error:
        raise InputError(f"{named}: {error}") from error
    return look


def read_first_look(folder: Path, calibration: Calibration) -> FirstLook:
    """That of the campaign in a folder."""
    try:
        result = Record.read(folder)
    except InputError as error:
        raise InputError(f"filter.first_look: {error}") from error
    return first_look_of(result, calibration, f"filter.first_look: {folder}")
