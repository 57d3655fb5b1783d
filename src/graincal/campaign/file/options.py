"""The tables [filter], [stop] and [run] of a calibration file."""

from __future__ import annotations

from typing import ClassVar, Literal

from pydantic import Field

from graincal.campaign.file.names import FileName
from graincal.campaign.file.section import Section
from graincal.campaign.file.values import Count, NotNegative, Off, Positive
from graincal.execution.cores import MOST_WORKERS
from graincal.inference import DEFAULT_METHOD, METHODS
from graincal.inference.posterior.posterior_filter import MOST_AHEAD
from graincal.inference.sampling.samples import MOST_SAMPLES
from graincal.models.python import LONGEST_TIMEOUT

MOST_ROUNDS = 1_000_000
"""Of limits on evaluations and iterations: what is longer is none."""


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
    runs: list[FileName] | None = Field(None, min_length=1, description='a list of the folders of campaigns and libraries of the same models, such as ["library"]')


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
    posterior_shift: NotNegative | Off = Field(0.25, description="standard deviations, not negative, or false")


class RunSection(Section):
    called: ClassVar[str] = "[run]"
    MOST: ClassVar[dict[str, float]] = {"workers": MOST_WORKERS, "expected_seconds": LONGEST_TIMEOUT}

    workers: Count | Literal["all"] = Field("all", description='a whole number above 0, or "all"')
    seed: int = Field(1, ge=0, description="a whole number, not negative")
    expected_seconds: Positive | None = Field(None, description="seconds above 0 that one evaluation takes on one core")
