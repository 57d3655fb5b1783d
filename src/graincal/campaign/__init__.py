"""A calibration as it runs and is stored: the loop around the filter, the folder that keeps it, and what it found."""

from typing import TYPE_CHECKING

from graincal.lazily import exported

if TYPE_CHECKING:
    from graincal.campaign.advice import Advice
    from graincal.campaign.advising import advise
    from graincal.campaign.calibration import Calibration
    from graincal.campaign.candidate_tests import CandidateTest
    from graincal.campaign.experiment import Experiment
    from graincal.campaign.exploring import explore
    from graincal.campaign.listener import Listener
    from graincal.campaign.prediction import Prediction, predict
    from graincal.campaign.remark import Remark
    from graincal.campaign.result import Answer, Candidate, Result
    from graincal.campaign.running import begin, calibrate, resume
    from graincal.campaign.trouble import FolderError

__all__ = ["Advice", "Answer", "Calibration", "Candidate", "CandidateTest", "Experiment", "FolderError", "Listener", "Prediction", "Remark", "Result", "advise", "begin", "calibrate", "explore", "predict", "resume"]

__getattr__ = exported(
    __name__,
    {
        "graincal.campaign.advice": ["Advice"],
        "graincal.campaign.advising": ["advise"],
        "graincal.campaign.calibration": ["Calibration"],
        "graincal.campaign.candidate_tests": ["CandidateTest"],
        "graincal.campaign.experiment": ["Experiment"],
        "graincal.campaign.exploring": ["explore"],
        "graincal.campaign.listener": ["Listener"],
        "graincal.campaign.prediction": ["Prediction", "predict"],
        "graincal.campaign.remark": ["Remark"],
        "graincal.campaign.result": ["Answer", "Candidate", "Result"],
        "graincal.campaign.running": ["begin", "calibrate", "resume"],
        "graincal.campaign.trouble": ["FolderError"],
    },
)
