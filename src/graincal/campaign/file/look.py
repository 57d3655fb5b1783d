"""The table [first_look] of a calibration file."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path
from typing import Any, ClassVar

from pydantic import Field, ValidationError

from graincal.campaign.asked.calibration import Calibration
from graincal.campaign.asked.experiment import Experiment
from graincal.campaign.file.experiments import ExperimentEntry
from graincal.campaign.file.model_section import ModelSection
from graincal.campaign.file.models import MODELS, StressPathModel
from graincal.campaign.file.options import MOST_ROUNDS
from graincal.campaign.file.section import Section, sentences, show
from graincal.data import InputError
from graincal.inference import Stop
from graincal.models import StressPathTest


class LookSection(Section):
    called: ClassVar[str] = "[first_look]"
    MOST: ClassVar[dict[str, float]] = {"max_evaluations": MOST_ROUNDS}

    model: dict[str, Any] = Field(min_length=1, description="a table of keys that make every experiment's model cheaper, such as { particles = 250 }")
    max_evaluations: int | None = Field(None, ge=10, description="a whole number, at least 10")

    def build(self, calibration: Calibration, entries: list[ExperimentEntry], folder: Path) -> Calibration:
        """The calibration by cheaper models. Most of its evaluations fill the ranges: it is to say where to look, not where exactly the best is."""
        n, options = calibration.space.size, calibration.filter_options
        most = self.max_evaluations or 32 * n
        kept = {name: options[name] for name in ("thin", "correlation_length", "discrepancy") if name in options}
        return replace(
            calibration,
            experiments=[self._cheaper(experiment, entry, folder) for experiment, entry in zip(calibration.experiments, entries)],
            filter_options={"first_batch": min(12 * n, most // 2), "batch": min(4 * n, max(2, most // 6)), "packing_scatter": False} | kept,
            stop=Stop(posterior_shift=False, max_iterations=False, max_evaluations=most),
            source="",
            truth={},
            known=None,
        )

    def _cheaper(self, experiment: Experiment, entry: ExperimentEntry, folder: Path) -> Experiment:
        section = self._section(entry)
        # Of a model of another kind, what both kinds know: a packing, a pressure, fixed parameters.
        table = {key: value for key, value in entry.model.given().items() if section is type(entry.model) or key in section.model_fields}
        if {"packing", *StressPathModel.PREPARATION} & self.model.keys():
            # One packing takes the place of another; without a void ratio, one of the same.
            instead = {"packing", *(StressPathModel.PREPARATION if "packing" in self.model else ())}
            table = {key: value for key, value in table.items() if key not in instead}
            if "particles" in self.model and isinstance(experiment.model, StressPathTest):
                table.setdefault("void_ratio", round(experiment.model.first_packing.void_ratio, 4))
        if {"density_scaling", "inertial_number"} & self.model.keys():
            table = {key: value for key, value in table.items() if key not in ("density_scaling", "inertial_number")}
        table |= self.model
        try:
            model = section.model_validate(table)
        except ValidationError as error:
            raise InputError("\n".join(f'first_look.model, with experiment "{entry.name}": {sentence}' for sentence in sentences(error, table))) from None
        return replace(experiment, model=model.build(folder, entry.control))

    def _section(self, entry: ExperimentEntry) -> type[ModelSection]:
        kind = self.model.get("kind", entry.model.kind)
        if not isinstance(kind, str) or kind not in MODELS:
            raise InputError(f"first_look.model.kind is {show(kind)}, and one of {', '.join(MODELS)} was expected.")
        return MODELS[kind]
