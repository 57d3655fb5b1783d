"""What a calibration found, for people: one HTML file that needs no network, and the same figures to print.

Figures are prepared once, as plain records (graincal.drawing), and drawn by two thin renderers.
"""

from graincal.campaign.found.findings import Finding, find
from graincal.report.words import summarise
from graincal.report.write import write_figures, write_report

__all__ = ["Finding", "find", "summarise", "write_figures", "write_report"]
