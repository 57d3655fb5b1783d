"""The calibrated contact law as lines for another DEM program."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from graincal.campaign.asked.file_names import file_name
from graincal.campaign.found.export import write_files
from graincal.campaign.found.record import Record
from graincal.data import InputError, Samples
from graincal.models import StressPathTest
from graincal.models.contact_lines import lammps, pfc, yade
from graincal.models.contact_lines.contact import Contact


class Program(NamedTuple):
    """Another DEM program: the name of the file for it, and what writes it."""

    file: str
    lines: Callable[[Contact], str]


PROGRAMS = {
    "yade": Program(yade.FILE_NAME, yade.yade_lines),
    "lammps": Program(lammps.FILE_NAME, lammps.lammps_lines),
    "pfc": Program(pfc.FILE_NAME, pfc.pfc_lines),
}
"""What the lines can be for, by its name on the command line."""


def export_contact(result: Record, theta: NDArray[np.float64], called: str, program: str, folder: Path, *, replace: bool = False) -> list[Path]:
    """Write the contact law at theta (n,), the campaign's `called`, such as "answer", for a program of PROGRAMS, and return the paths: one file where all experiments have the same, or else one for each.

    Raises InputError where an experiment's model has no contact law that graincal knows, and for files that are there already, unless they are to be replaced.
    """
    wanted, texts = PROGRAMS[program], contact_texts(result, theta, called, program)
    if len(set(texts.values())) == 1:
        return write_files(folder, {wanted.file: next(iter(texts.values()))}, replace)
    stem, dot, ending = wanted.file.partition(".")
    return write_files(folder, {f"{stem}_{file_name(name)}{dot}{ending}": text for name, text in texts.items()}, replace)


def contact_texts(result: Record, theta: NDArray[np.float64], called: str, program: str) -> dict[str, str]:
    """The lines for each experiment, by its name, as `export_contact` writes them. Raises InputError where an experiment's model has no contact law that graincal knows."""
    texts = {}
    for number, experiment in enumerate(result.experiments):
        test = experiment.model
        if not isinstance(test, StressPathTest):
            raise InputError(
                f'export: contact lines are of models whose contact law graincal knows, and that of the experiment "{experiment.name}" is no test of its own engine: export its samples with --to csv.'
            )
        seen = result.space.seen_by(number, Samples(np.zeros(1, dtype=np.int64), theta[None], result.space.names))
        values = dict(zip(test.parameters, test.arrange(seen)[0].tolist()))
        radii = np.concatenate([packing.radii for packing in test.packings])
        texts[experiment.name] = PROGRAMS[program].lines(Contact(test.law, values, radii, f"{called} of {result.folder or 'a calibration'}"))
    return texts
