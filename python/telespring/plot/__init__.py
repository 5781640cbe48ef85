"""Figures for scripts and notebooks: each function draws one result and returns matplotlib axes.

Every function takes `ax`, the axes to draw on; without it, it makes a pyplot figure.
"""

from telespring.plot.dyad import frequency_response, nyquist, response
from telespring.plot.maps import stability_map
from telespring.plot.prediction import prediction_map
from telespring.plot.trials import tracking_error, trials

__all__ = [
    "frequency_response",
    "nyquist",
    "prediction_map",
    "response",
    "stability_map",
    "tracking_error",
    "trials",
]
