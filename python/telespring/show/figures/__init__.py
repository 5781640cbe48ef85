"""The figures of the report, drawn with matplotlib.

Every function takes plain numbers and returns a `matplotlib.figure.Figure`; none uses pyplot or computes
results. `to_svg` turns a figure into text for the report.
"""

from telespring.show.figures.arms import ArmsPanel, arms_figure
from telespring.show.figures.calibration import CellSeries, cells_figure
from telespring.show.figures.comparison import DelayCurve, DelayPanel, delay_figure
from telespring.show.figures.comparison_account import AccountTrial, account_figure
from telespring.show.figures.comparison_plane import Boundary, PlanePanel, PlanePoint, plane_figure
from telespring.show.figures.frequency import FrequencyCurve, FrequencyFamily, frequency_figure
from telespring.show.figures.maps import HORIZON, MapAxis, MapColumn, StudyMark, region_map, tier_map
from telespring.show.figures.nyquist import NyquistPanel, nyquist_figure
from telespring.show.figures.poses import PoseRange, poses_figure
from telespring.show.figures.responses import ResponsePanel, response_figure
from telespring.show.figures.schematics import DrawnSide, dyad_schematic, laboratory_schematic, loop_schematic
from telespring.show.figures.strategy_looks import StrategyLook, looks_of_strategies
from telespring.show.figures.style import to_svg
from telespring.show.figures.tracking_errors import ErrorGroup, error_figure
from telespring.show.figures.trials import TrialPanel, trajectory_figure

__all__ = [
    "HORIZON",
    "AccountTrial",
    "ArmsPanel",
    "Boundary",
    "CellSeries",
    "DelayCurve",
    "DelayPanel",
    "DrawnSide",
    "ErrorGroup",
    "FrequencyCurve",
    "FrequencyFamily",
    "MapAxis",
    "MapColumn",
    "NyquistPanel",
    "PlanePanel",
    "PlanePoint",
    "PoseRange",
    "ResponsePanel",
    "StrategyLook",
    "StudyMark",
    "TrialPanel",
    "account_figure",
    "arms_figure",
    "cells_figure",
    "delay_figure",
    "dyad_schematic",
    "error_figure",
    "frequency_figure",
    "laboratory_schematic",
    "looks_of_strategies",
    "loop_schematic",
    "nyquist_figure",
    "plane_figure",
    "poses_figure",
    "region_map",
    "response_figure",
    "tier_map",
    "to_svg",
    "trajectory_figure",
]
