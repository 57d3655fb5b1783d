"""A calibration as it runs and is stored: the loop around the filter, the folder that keeps it, and what it found."""

from typing import TYPE_CHECKING

from graincal.lazily import exported

if TYPE_CHECKING:
    from graincal.campaign.asked.calibration import Calibration
    from graincal.campaign.asked.experiment import Experiment
    from graincal.campaign.found.answer import Answer, Candidate
    from graincal.campaign.found.comparison import compare
    from graincal.campaign.found.prediction import Prediction, predict
    from graincal.campaign.found.record import Record
    from graincal.campaign.found.remark import Remark
    from graincal.campaign.run.advice import Advice
    from graincal.campaign.run.advising import advise
    from graincal.campaign.run.candidate_tests import CandidateTest
    from graincal.campaign.run.exploring import explore
    from graincal.campaign.run.running import begin, calibrate, resume
    from graincal.campaign.run.steps import Step
    from graincal.campaign.stored.listener import Listener
    from graincal.campaign.stored.trouble import FolderError

__all__ = [
    "Advice",
    "Answer",
    "Calibration",
    "Candidate",
    "CandidateTest",
    "Experiment",
    "FolderError",
    "Listener",
    "Prediction",
    "Record",
    "Remark",
    "Step",
    "advise",
    "begin",
    "calibrate",
    "compare",
    "explore",
    "predict",
    "resume",
]

__getattr__ = exported(
    __name__,
    {
        "graincal.campaign.run.advice": ["Advice"],
        "graincal.campaign.run.advising": ["advise"],
        "graincal.campaign.asked.calibration": ["Calibration"],
        "graincal.campaign.run.candidate_tests": ["CandidateTest"],
        "graincal.campaign.asked.experiment": ["Experiment"],
        "graincal.campaign.run.exploring": ["explore"],
        "graincal.campaign.stored.listener": ["Listener"],
        "graincal.campaign.found.comparison": ["compare"],
        "graincal.campaign.found.prediction": ["Prediction", "predict"],
        "graincal.campaign.found.remark": ["Remark"],
        "graincal.campaign.found.answer": ["Answer", "Candidate"],
        "graincal.campaign.found.record": ["Record"],
        "graincal.campaign.run.running": ["begin", "calibrate", "resume"],
        "graincal.campaign.run.steps": ["Step"],
        "graincal.campaign.stored.trouble": ["FolderError"],
    },
)
