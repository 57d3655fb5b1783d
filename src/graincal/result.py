"""What a calibration found, and what is said of it: what `calibrate` and `resume` return."""

from __future__ import annotations

from functools import cached_property
from pathlib import Path
from typing import TYPE_CHECKING, Any

from graincal.campaign.found.record import Record
from graincal.campaign.found.remark import Remark
from graincal.campaign.found.remarks import remarks
from graincal.inference.iterative.close_fits import CloseFits, close_fits

if TYPE_CHECKING:
    from pandas import DataFrame

    from graincal.campaign.found.emulated import Emulated
    from graincal.campaign.found.findings import Finding
    from graincal.campaign.found.summary import Summary
    from graincal.inference.sampling.groups import Group
    from graincal.report.plots import Plots

# What is imported where it is used draws in scikit-learn, Matplotlib or Plotly, each of which takes a second.


class Result(Record):
    """What a campaign found in its complete iterations. N samples in the order asked, n parameters, E experiments.

    samples (N, n), ids (N,), iteration (N,): every sample and the iteration that asked for it. errors (N,): percent, Eq. 6; NaN for a failure.
    observable_errors (N, P): percent, Eq. 5, by experiment and observable. failed (N,): samples without a usable response in some experiment.
    Everything else that a `Record` has, and below what follows from it.
    """

    @cached_property
    def remarks(self) -> tuple[Remark, ...]:
        """What was found, why not to trust it and what it takes for granted, by the method "posterior": what the report says of it, as records with codes. By other
        methods none but that problems were accepted. It takes some seconds, for the emulators are made again."""
        return remarks(self, self.emulated.known if self.emulated else None)

    @cached_property
    def emulated(self) -> Emulated | None:
        """What the emulators say by the method "posterior": predictive bands, what each observable tells, the separate groups of values that fit. None by other methods, and where nothing has been emulated."""
        from graincal.campaign.found.emulated import Emulated

        return Emulated.of(self)

    @cached_property
    def groups(self) -> tuple[Group, ...]:
        """Separate groups of parameter values among which the weight is divided, the heaviest first; empty for a single one, and where there is no posterior."""
        from graincal.inference.sampling.groups import find_groups

        return find_groups(self.space, self.posterior) if self.posterior is not None else ()

    @cached_property
    def close_fits(self) -> CloseFits | None:
        """By the paper's method: the samples that fit about as well as the best, whatever their weights. None by the method "posterior", whose runs are `fits_about_as_well`, and where no sample has a response."""
        return None if self.has_posterior else close_fits(self.iterations)

    @cached_property
    def findings(self) -> tuple[Finding, ...]:
        """By the paper's method: what the samples say of each parameter, (n,). Empty by the method "posterior", which has `remarks`."""
        from graincal.campaign.found.findings import find

        return () if self.has_posterior else find(self.space, self.iterations, self.truth)

    @cached_property
    def _summary(self) -> Summary:
        from graincal.campaign.found.summary import summarise

        return summarise(self, self.emulated)

    def summary(self) -> Summary:
        """Each parameter with its answer, 90 % interval, unit, range and what informs it: a table at a prompt and in a notebook, records by `summary["phi"]`."""
        return self._summary

    def to_dataframe(self) -> DataFrame:
        """Every evaluation as a row of a pandas table, by the sample's id. Raises InputError where pandas is not installed, which the extra `notebook` brings."""
        from graincal.campaign.found.evaluations_table import to_dataframe

        return to_dataframe(self)

    def to_arviz(self) -> Any:
        """The posterior as ArviZ reads it, with sample_stats, prior, posterior_predictive and observed_data: an xarray.DataTree, or an InferenceData before ArviZ 1. One chain of 500 draws of equal weight.

        Raises InputError where ArviZ is not installed, which the extra `notebook` brings, and where there is no posterior.
        """
        from graincal.campaign.found.arviz_groups import to_arviz

        return to_arviz(self, self.emulated)

    @property
    def plot(self) -> Plots:
        """The report's figures as Matplotlib's axes: plot.curves(), plot.pairs(), plot.trace(), plot.predict()."""
        from graincal.report.plots import Plots

        return Plots(self)

    def _repr_html_(self) -> str:
        """What a notebook shows: the summary as a table."""
        return self.summary()._repr_html_()

    def report(self, path: str | Path) -> Path:
        """Write the report, one HTML file, and return its path."""
        from graincal.report import write_report

        write_report(self, Path(path))
        return Path(path)
