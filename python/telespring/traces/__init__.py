"""What a recorded trace of a network allows: a play-out delay, and a stiffness that is proven with it."""

from telespring._core import BurstFit, JitterFit, PlayedTrace, Trace, TraceFit, TraceStatistics
from telespring.traces.assessment import RecordedWay, TraceAssessment, assess_trace
from telespring.traces.evidence import TraceEvidence
from telespring.traces.missing_rows import MissingRows
from telespring.traces.playouts import PlayoutChoice
from telespring.traces.reading import read_trace

__all__ = [
    "BurstFit",
    "JitterFit",
    "MissingRows",
    "PlayedTrace",
    "PlayoutChoice",
    "RecordedWay",
    "Trace",
    "TraceAssessment",
    "TraceEvidence",
    "TraceFit",
    "TraceStatistics",
    "assess_trace",
    "read_trace",
]
