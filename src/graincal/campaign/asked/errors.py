"""Measurement errors as they were understood, in sentences."""

from __future__ import annotations

from graincal.data import MeasurementError, Reference
from graincal.inference.likelihood.error_model import USUAL_ERROR, measurement_errors


def describe_errors(reference: Reference) -> list[str]:
    """A sentence for each observable, and one for what else matters to the method "posterior"."""
    said = []
    for name, error in zip(reference.names, measurement_errors(reference)):
        stated = name in reference.measurement_errors
        taken = (
            ""
            if stated
            else f", taken for {100 * USUAL_ERROR:g} % of the peak{' by its variance share' if len(set(reference.shares)) > 1 else ''}: none is stated"
        )
        said.append(f"measurement error of {name}: {in_words(error)}{taken}")
    if reference.control_step:
        said.append(f"{reference.control_name} was read in steps of {reference.control_step:g}")
    if reference.simulated:
        said.append("the reference is a simulation and scatters like one")
    return said


def in_words(error: MeasurementError) -> str:
    """An error in a laboratory's terms."""
    parts = [f"sd {error.absolute:.3g}"] if error.absolute else []
    parts += [f"{100 * error.relative:.3g} % of the value"] if error.relative else []
    parts += [f"steps of {error.step:.3g}"] if error.step else []
    parts += [f"noise of sd {error.noise:.3g} from row to row"] if error.noise else []
    return ", ".join(parts)
