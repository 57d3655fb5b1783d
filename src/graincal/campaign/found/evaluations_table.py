"""Every evaluation as a row of a pandas table."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from graincal.campaign.asked.calibration import round_of
from graincal.errors import not_installed

if TYPE_CHECKING:
    from pandas import DataFrame

    from graincal.campaign.found.record import Record


def to_dataframe(result: Record) -> DataFrame:
    """A row for each sample, by its id: batch or iteration, parameters, errors in percent, weight within its iteration, whether it failed or was stopped early, seconds.

    Raises InputError where pandas is not installed.
    """
    try:
        import pandas as pd
    except ImportError as error:
        raise not_installed("to_dataframe", "pandas", "notebook", error) from None
    pairs = [f"error: {experiment.name}: {name}" for experiment in result.experiments for name in experiment.reference.names]
    columns = {round_of(result.calibration.method): result.iteration}
    columns |= dict(zip(result.space.names, result.samples.T))
    columns |= {"error": result.errors} | dict(zip(pairs, result.observable_errors.T))
    if not result.has_posterior:
        columns["weight"] = np.concatenate([iteration.final_weights for iteration in result.iterations])
    columns |= {"failed": result.failed, "stopped": result.stopped}
    columns |= {
        f"seconds: {experiment.name}" if len(result.experiments) > 1 else "seconds": result.seconds[:, number]
        for number, experiment in enumerate(result.experiments)
    }
    return pd.DataFrame(columns, index=pd.Index(result.ids, name="sample"))
