"""What the tables [experiment.model] of all kinds have in common."""

from __future__ import annotations

from pathlib import Path
from typing import ClassVar

from graincal.campaign.file.section import Section
from graincal.models import Model


class ModelSection(Section):
    """A table that describes a model, of a kind of its own."""

    called: ClassVar[str] = "[experiment.model]"

    kind: str

    def build(self, folder: Path, control: str) -> Model:
        """The model that is described, in a file of this folder, for an experiment with this control."""
        raise NotImplementedError
