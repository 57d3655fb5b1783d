"""The tables [filter], [stop] and [run] of a calibration file."""

from __future__ import annotations

from pathlib import Path
from typing import ClassVar, Literal

from pydantic import Field, model_validator

from graincal.campaign.asked.place import PARSL, Place
from graincal.campaign.file.blocks import BlocksSection
from graincal.campaign.file.names import FileName, Shown
from graincal.campaign.file.section import Section, mistake, show
from graincal.campaign.file.values import Count, NotNegative, Off, Positive, from_root
from graincal.execution.cores import MOST_WORKERS
from graincal.inference import DEFAULT_METHOD, METHODS
from graincal.inference.posterior.options import MOST_AHEAD
from graincal.inference.sampling.samples import MOST_SAMPLES
from graincal.models.python import LONGEST_TIMEOUT
from graincal.suggestion import did_you_mean

MOST_ROUNDS = 1_000_000
"""Of limits on evaluations and iterations: what is longer is none."""


LOCAL = "local"
"""The executor of this machine's own workers."""


class FilterSection(Section):
    called: ClassVar[str] = "[filter]"
    MOST: ClassVar[dict[str, float]] = {"first_batch": MOST_SAMPLES, "batch": MOST_SAMPLES, "ahead": MOST_AHEAD, "correlation_length": 1e6, "runs": 1_000}

    method: str = Field(DEFAULT_METHOD, description=" or ".join(f'"{method}"' for method in METHODS))
    alpha: Positive = Field(10, description="a number above 0")
    effective_sample_size: float = Field(0.3, gt=0, lt=1, description="a number between 0 and 1")
    scale: Literal["peak", "pointwise"] = Field("peak", description='"peak" or "pointwise"')
    covariance: Literal["tied", "full"] = Field("tied", description='"tied" or "full"')
    first_batch: int | None = Field(None, ge=2, description="a whole number above 1")
    batch: int | None = Field(None, ge=2, description="a whole number above 1")
    ahead: int = Field(0, ge=0, description="a whole number, not negative")
    early_stop: bool = Field(False, description="true or false")
    thin: bool | None = Field(None, description="true or false")
    correlation_length: Positive | None = Field(None, description="a number above 0, in lengths of the whole curve")
    discrepancy: bool | None = Field(None, description="true or false")
    packing_scatter: bool = Field(True, description="true or false")
    first_look: FileName | None = Field(None, min_length=1, description="the folder of a campaign of cheaper models on the same experiments")
    runs: list[FileName] | None = Field(
        None, min_length=1, description='a list of the folders of campaigns and libraries of the same models, such as ["library"]'
    )


class StopSection(Section):
    called: ClassVar[str] = "[stop]"
    MOST: ClassVar[dict[str, float]] = {"max_iterations": MOST_ROUNDS, "max_evaluations": MOST_ROUNDS}

    s: NotNegative | Off = Field(0.01, description="a number, not negative, or false")
    gl_error_increment: NotNegative | Off = Field(0.2, description="percentage points, not negative, or false")
    error: NotNegative | Off = Field(2.0, description="percent, not negative, or false")
    error_increment: NotNegative | Off = Field(0.2, description="percentage points, not negative, or false")
    max_iterations: Count | Off | None = Field(None, description="a whole number above 0, or false")
    max_evaluations: Count | Off = Field(False, description="a whole number above 0, or false")
    hours: Positive | Off = Field(False, description="hours of wall time, above 0, or false")
    posterior_shift: NotNegative | Off = Field(0.2, description="standard deviations, not negative, or false")


class RunSection(Section):
    called: ClassVar[str] = "[run]"
    MOST: ClassVar[dict[str, float]] = {"workers": MOST_WORKERS, "expected_seconds": LONGEST_TIMEOUT}

    workers: Count | Literal["all"] = Field("all", description='a whole number above 0, or "all"')
    seed: int = Field(1, ge=0, description="a whole number, not negative")
    expected_seconds: Positive | None = Field(None, description="seconds above 0 that one evaluation takes on one core")
    executor: Shown = Field(LOCAL, description='"local", "parsl", or a function as "module:function"')
    parsl: BlocksSection | None = Field(None, description='a table [run.parsl] with provider = "local", "slurm", "pbs" or "lsf"')

    @model_validator(mode="after")
    def _one_executor(self) -> RunSection:
        if self.executor not in (LOCAL, PARSL) and not all(part.strip() for part in self.executor.partition(":")):
            raise mistake(
                f'.executor must be "{LOCAL}", "{PARSL}", or a function as "module:function", not {show(self.executor)}{did_you_mean(self.executor, (LOCAL, PARSL))}'
            )
        if self.executor == PARSL and self.parsl is None:
            raise mistake(f'.parsl is missing, and with executor = "{PARSL}" a table [run.parsl] with provider = "local", "slurm", "pbs" or "lsf" was expected')
        if self.parsl is not None and "executor" not in self.model_fields_set:
            raise mistake(f'.executor is missing, and with a table [run.parsl] executor = "{PARSL}" was expected, or "{LOCAL}", which leaves that table aside')
        return self

    def place(self, folder: Path) -> Place | None:
        """Where evaluations run; None for workers of graincal's own. folder: the file's."""
        if self.executor == LOCAL:
            return None
        if self.executor == PARSL:
            assert self.parsl is not None, "the table is there"
            return Place(PARSL, self.parsl.given())
        return Place(self.executor, folder=str(from_root(folder)))
