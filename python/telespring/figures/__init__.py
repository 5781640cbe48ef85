"""The figures of the paper, drawn from numbers that somebody else computed.

Every function takes plain numbers and gives a `matplotlib.figure.Figure`; none touches pyplot or
computes stability. `to_svg` makes the text that stands in the report.
"""

from telespring.figures.frequency import FrequencyCurve, FrequencyFamily, frequency_figure
from telespring.figures.maps import MapAxis, MapColumn, region_map, tier_map
from telespring.figures.nyquist import NyquistPanel, nyquist_figure
from telespring.figures.responses import ResponsePanel, response_figure
from telespring.figures.schematics import dyad_schematic, laboratory_schematic, loop_schematic
from telespring.figures.style import to_svg

__all__ = [
    "FrequencyCurve",
    "FrequencyFamily",
    "MapAxis",
    "MapColumn",
    "NyquistPanel",
    "ResponsePanel",
    "dyad_schematic",
    "frequency_figure",
    "laboratory_schematic",
    "loop_schematic",
    "nyquist_figure",
    "region_map",
    "response_figure",
    "tier_map",
    "to_svg",
]
