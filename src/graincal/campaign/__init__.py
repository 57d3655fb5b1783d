"""A calibration as it runs and is stored: the loop around the filter, the folder that keeps it, and what it found."""

from graincal.campaign.calibration import Calibration
from graincal.campaign.experiment import Experiment, Model
from graincal.campaign.listener import Listener
from graincal.campaign.prediction import Prediction, predict
from graincal.campaign.result import Answer, Candidate, Result
from graincal.campaign.running import begin, calibrate, resume
from graincal.campaign.trouble import FolderError

__all__ = ["Answer", "Calibration", "Candidate", "Experiment", "FolderError", "Listener", "Model", "Prediction", "Result", "begin", "calibrate", "predict", "resume"]
