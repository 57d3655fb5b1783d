"""One thing that speaks against a calibration before it is run: as a record that programs read by its code and people by its sentence."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, Literal

Level = Literal["problem", "note"]

CODES: dict[Level, dict[str, str]] = {
    "problem": {
        "begins-sheared": "the stress ratio is not 1 where the strain is 0",
        "constant-observable": "an observable never changes",
        "contradicts-file": "the laboratory file proves something else than the calibration file says",
        "dilates-first": "the volumetric strain dilates first and contracts later, as if its sign were turned",
        "large-error": "a measurement error is as large as what was measured",
        "lateral-stress-not-constant": "a stress ratio is made of q or σ1 with a lateral stress that is not constant in this test",
        "mean-stress-not-confining": "the mean stress is not the confining pressure where it should be",
        "negative-stress": "a stress that must be positive is not",
        "negative-strain": "the axial strain goes far below 0",
        "other-pressure": "the reference's confining pressure is not the model's",
        "placeholder-pressure": "the confining pressure is still the one that an earlier init put in for none",
        "porosity-as-void-ratio": "the void ratio is a porosity",
        "pore-pressure-beyond": "the excess pore pressure exceeds the confining pressure",
        "pore-pressure-not-excess": "the excess pore pressure is not 0 where the strain is 0",
        "pore-pressure-small": "the excess pore pressure of an undrained test is next to nothing",
        "specific-volume-as-void-ratio": "the void ratio is a specific volume",
        "strain-too-large": "a strain is too large, as by a factor of 100",
        "strain-too-small": "a strain is too small, as by a factor of 100",
        "strain-not-converted": "an engineering strain is asked for where nothing converts it",
        "stress-ratio-high": "the stress ratio is higher than that of any soil",
        "stress-ratio-low": "the stress ratio is on the wrong side of 1, or too far from it",
        "stresses-elsewhere": "the stresses of the control are far from the confining pressure",
        "unsheared": "the stress ratio stays at 1",
        "void-ratio-impossible": "no soil has such a void ratio",
        "void-ratio-off": "the reference's first void ratio is not the packing's",
        "void-ratio-out-of-reach": "the grading does not pack to the void ratio",
        "void-ratio-percent": "the void ratio, or a porosity, is in percent",
        "volume-changes": "the volume changes in an undrained test",
        "volumetric-beyond-axial": "the volumetric strain goes beyond the axial one",
    },
    "note": {
        "below-one": "the stress ratio is slightly below 1 at the beginning",
        "contradicts-words": "the laboratory file says something else in words than the calibration file says",
        "check-marks": "lines of the file still say CHECK",
        "dilates-at-first": "the volumetric strain dilates at first, which may be right: by little, or throughout without a peak of the stress ratio",
        "far-from-quasi-static": "a setting of the test, or a pressure or a parameter, is unusual",
        "file-not-linked": "a program is given a file that its folder does not see",
        "key-without-effect": "a key changes nothing",
        "limit-never-reached": "a limit is never reached, for another one ends the calibration before",
        "limit-not-used": "a limit on evaluations is not used to the last, for rounds are not cut short",
        "more-workers-than-runs": "there are more workers than runs that may be under way at once",
        "more-workers-than-cores": "there are more workers than cores",
        "place-not-ready": "where evaluations are to run, something is not installed here",
        "reading": "what was done with the file as it was read",
        "simulated-elsewhere": "a simulated reference is taken for one on another packing",
        "starts-below-zero": "the axial strain begins slightly below 0",
        "states-put-together": "the rows of a dense reference are put together",
        "unread-so-far": "an experiment, or the file, cannot be read before its questions are answered",
        "unusual-parameter": "a range or a value is unusual, as in another unit",
        "void-ratio-near": "the reference's first void ratio is not quite the packing's",
    },
}
"""Every code by its level, and what it says: a contract for programs."""

LEVELS: dict[str, Level] = {code: level for level, codes in CODES.items() for code in codes}


@dataclass(frozen=True)
class Doubt:
    """code: one of CODES, which never changes its meaning. sentence: for people, without the name of the experiment; experiment: that name, None for what is of all."""

    code: str
    sentence: str
    experiment: str | None = None

    def __str__(self) -> str:
        return self.sentence if self.experiment is None else f'Experiment "{self.experiment}": {self.sentence}'

    @property
    def level(self) -> Level:
        """Of a "problem", next to certainly a mistake, nothing is calibrated unless it is accepted. A "note" is possible, and yet seldom meant."""
        return LEVELS[self.code]

    def as_json(self) -> dict[str, Any]:
        """The record as `graincal check --json` has it."""
        return {"experiment": self.experiment, "code": self.code, "sentence": self.sentence}
