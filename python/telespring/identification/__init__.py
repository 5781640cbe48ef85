"""Identification of a robot (Appendix B): movements that excite it, and its parameters from a log.

`identify` estimates the parameters; `paper_excitation` and `design_excitation` provide movements; `read_log`
reads CSV, Parquet and MAT files; `write_robot` writes a file for studies and `telespring decide`.
"""

from telespring.identification.estimation import identify, identify_logs
from telespring.identification.excitation import Excitation, Extremes, design_excitation, paper_excitation
from telespring.identification.log_reading import Log, read_log
from telespring.identification.results import AxisIdentification, CrossInertia, Estimate, Identification
from telespring.identification.reweighting import Reweighting, paper_reweightings
from telespring.identification.robot_file import robot_toml, write_robot

__all__ = [
    "AxisIdentification",
    "CrossInertia",
    "Estimate",
    "Excitation",
    "Extremes",
    "Identification",
    "Log",
    "Reweighting",
    "design_excitation",
    "identify",
    "identify_logs",
    "paper_excitation",
    "paper_reweightings",
    "read_log",
    "robot_toml",
    "write_robot",
]
