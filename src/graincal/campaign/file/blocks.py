"""The table [run.parsl] of a calibration file."""

from __future__ import annotations

import re
from typing import Annotated, ClassVar, Literal

from pydantic import AfterValidator, Field, model_validator

from graincal.campaign.file.section import Section, mistake, refused, show
from graincal.campaign.file.values import Count


def _duration(text: str) -> str:
    """As HH:MM:SS, of at least two minutes: a job begins in the first."""
    if (found := re.fullmatch(r"(\d{1,4}):([0-5]\d):([0-5]\d)", text, re.ASCII)) is None:
        raise refused(f' must be hours, minutes and seconds such as "04:00:00", not {show(text)}')
    if 3600 * int(found[1]) + 60 * int(found[2]) + int(found[3]) < 120:
        raise refused(f' is {show(text)}, and at least "00:02:00" was expected')
    return text


def _one_word(text: str) -> str:
    if not re.fullmatch(r"[\w.:/@%+,=-]+", text, re.ASCII):
        raise refused(f" must be one word of letters, digits and . : / @ % + , = -, not {show(text)}")
    return text


Duration = Annotated[str, AfterValidator(_duration)]
Word = Annotated[str, AfterValidator(_one_word)]

_ONLY_SLURM = ("qos", "nodes_per_block")
_NOT_LOCAL = ("partition", "account", "qos", "walltime", "nodes_per_block", "memory_per_node", "scheduler_options", "address")


class BlocksSection(Section):
    called: ClassVar[str] = "[run.parsl]"
    MOST: ClassVar[dict[str, float]] = {"nodes_per_block": 10_000, "cores_per_node": 10_000, "memory_per_node": 1_000_000, "max_blocks": 10_000}

    provider: Literal["local", "slurm", "pbs", "lsf"] = Field(description='"local", "slurm", "pbs" or "lsf"')
    partition: Word | None = Field(None, description="the name of a partition or queue")
    account: Word | None = Field(None, description="the name of an account or project")
    qos: Word | None = Field(None, description="the name of a quality of service")
    walltime: Duration = Field("01:00:00", description='hours, minutes and seconds such as "04:00:00"')
    nodes_per_block: Count = Field(1, description="a whole number above 0")
    cores_per_node: Count | None = Field(None, description="a whole number above 0")
    memory_per_node: Count | None = Field(None, description="a whole number of GB above 0")
    max_blocks: Count = Field(1, description="a whole number above 0")
    worker_init: str = Field("", description='lines of the shell, such as "module load yade"')
    scheduler_options: str = Field("", description='lines for the head of the submit script, such as "#SBATCH --constraint=fast"')
    address: Word | None = Field(None, description="the address of this machine that the nodes reach")

    @model_validator(mode="after")
    def _of_the_provider(self) -> BlocksSection:
        given = self.model_fields_set
        if wrong := [key for key in _NOT_LOCAL if key in given and self.provider == "local"]:
            raise mistake(f'.{wrong[0]} is a key of clusters, and provider = "local" knows none of {", ".join(_NOT_LOCAL)}')
        if self.provider in ("pbs", "lsf"):
            if wrong := [key for key in _ONLY_SLURM if key in given]:
                raise mistake(f'.{wrong[0]} is a key of provider = "slurm", and not known with "{self.provider}"; scheduler_options may say it')
            if self.cores_per_node is None:
                raise mistake(f'.cores_per_node is missing, and with provider = "{self.provider}" a whole number above 0 was expected')
        return self
