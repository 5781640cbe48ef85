"""Stability of two people who each hold a robot, joined by a virtual spring over a network.

Everything public is listed here. All numbers are in SI units: m, s, N, kg, N/m, N·s/m, rad/s.
"""

from typing import TYPE_CHECKING

from telespring._core import __version__
from telespring._deprecated import old_names, serve_moved_modules
from telespring._errors import ApproximationWarning, CertificateWarning, InvalidInput
from telespring.model import (
    Adversary,
    Agent,
    Architecture,
    Arm,
    Condition,
    Coupling,
    DelaySystem,
    Dyad,
    DyadAxis,
    Experiment,
    GuardOverdraft,
    JudgedNetwork,
    LaboratorySettings,
    Network,
    Operator,
    OperatorRange,
    Robot,
    Study,
    Task,
    Uncertainty,
    hman,
)
from telespring.theory.criteria import (
    Crossing,
    NoiseFit,
    critical_stiffness,
    crossings,
    decay_stiffness,
    fit_noise,
    maximum_delay,
    maximum_stiffness,
    minimum_damping,
    stability_map,
    stable_delays,
    unstable_root_count,
)
from telespring.theory.dde import DelaySolution, solve_dde
from telespring.theory.response import (
    FrequencyGrid,
    FrequencyMargin,
    FrequencyResponse,
    Nyquist,
    ResponseCurve,
    frequency_grid,
    frequency_response,
    mobility_matrix,
    nyquist,
    open_loop,
    partner_response,
    transfer_matrix,
)
from telespring.theory.simulation import Sampled, Signal, Sine, Trajectory, simulate, simulate_array
from telespring.theory.spectrum import Spectrum, certified_roots, characteristic_roots, spectral_abscissa
from telespring.theory.verdicts import (
    AxisTier,
    AxisVerdict,
    DelayBudget,
    DelayLimit,
    OperatorPoint,
    PaperVerdict,
    Remedies,
    SampledSpectrum,
    StiffnessAllowed,
    StiffnessMargin,
    Verdict,
    Verdicts,
    delay_limit,
    is_stable_over_delays,
    is_stable_over_stiffnesses,
    verdicts,
)

__all__ = [
    "Adversary",
    "Agent",
    "Answer",
    "ApproximationWarning",
    "Architecture",
    "Arm",
    "AxisTier",
    "AxisVerdict",
    "BidsExport",
    "BurstFit",
    "CertificateWarning",
    "Comparison",
    "Condition",
    "Coupling",
    "Crossing",
    "DelayBudget",
    "DelayLimit",
    "DelaySolution",
    "DelaySystem",
    "Dyad",
    "DyadAxis",
    "Experiment",
    "FrequencyGrid",
    "FrequencyMargin",
    "FrequencyResponse",
    "GuardOverdraft",
    "InvalidInput",
    "JitterFit",
    "JudgedNetwork",
    "LaboratorySettings",
    "MissingRows",
    "Network",
    "NoiseFit",
    "Nyquist",
    "Operator",
    "OperatorPoint",
    "OperatorRange",
    "PaperVerdict",
    "PlayedTrace",
    "PlayoutChoice",
    "RecordedWay",
    "Remedies",
    "Replay",
    "ResponseCurve",
    "Robot",
    "Sampled",
    "SampledSpectrum",
    "SessionRecording",
    "Signal",
    "Sine",
    "SiteRecording",
    "Spectrum",
    "StiffnessAllowed",
    "StiffnessMargin",
    "Study",
    "Task",
    "Trace",
    "TraceAssessment",
    "TraceEvidence",
    "TraceFit",
    "TraceStatistics",
    "Trajectory",
    "Uncertainty",
    "Verdict",
    "Verdicts",
    "__version__",
    "analyse_recording",
    "assess_trace",
    "certified_roots",
    "characteristic_roots",
    "compare",
    "critical_stiffness",
    "crossings",
    "decay_stiffness",
    "decide",
    "delay_limit",
    "explore",
    "export_bids",
    "export_mat",
    "fit_noise",
    "frequency_grid",
    "frequency_response",
    "hman",
    "is_stable_over_delays",
    "is_stable_over_stiffnesses",
    "maximum_delay",
    "maximum_stiffness",
    "merge_recordings",
    "merge_shards",
    "merge_surveys",
    "minimum_damping",
    "mobility_matrix",
    "nyquist",
    "open_loop",
    "partner_response",
    "read_recording",
    "read_trace",
    "rehearse",
    "replay",
    "simulate",
    "simulate_array",
    "solve_dde",
    "spectral_abscissa",
    "stability_map",
    "stable_delays",
    "survey_dyads",
    "sweep",
    "transfer_matrix",
    "unsafe_quantile",
    "unstable_root_count",
    "verdicts",
]

serve_moved_modules()
if TYPE_CHECKING:
    from telespring import plot as plot
    from telespring.analysis.sessions import analyse_recording as analyse_recording
    from telespring.answer import Answer as Answer
    from telespring.answer import decide as decide
    from telespring.app.widget import explore as explore
    from telespring.comparison import Comparison as Comparison
    from telespring.comparison import compare as compare
    from telespring.exchange import BidsExport as BidsExport
    from telespring.exchange import export_bids as export_bids
    from telespring.exchange import export_mat as export_mat
    from telespring.recording import SessionRecording as SessionRecording
    from telespring.recording import merge_recordings as merge_recordings
    from telespring.recording import read_recording as read_recording
    from telespring.rehearsal import rehearse as rehearse
    from telespring.replays import Replay as Replay
    from telespring.replays import SiteRecording as SiteRecording
    from telespring.replays import replay as replay
    from telespring.sweeps import merge_shards as merge_shards
    from telespring.sweeps import merge_surveys as merge_surveys
    from telespring.sweeps import survey_dyads as survey_dyads
    from telespring.sweeps import sweep as sweep
    from telespring.sweeps import unsafe_quantile as unsafe_quantile
    from telespring.traces import BurstFit as BurstFit
    from telespring.traces import JitterFit as JitterFit
    from telespring.traces import MissingRows as MissingRows
    from telespring.traces import PlayedTrace as PlayedTrace
    from telespring.traces import PlayoutChoice as PlayoutChoice
    from telespring.traces import RecordedWay as RecordedWay
    from telespring.traces import Trace as Trace
    from telespring.traces import TraceAssessment as TraceAssessment
    from telespring.traces import TraceEvidence as TraceEvidence
    from telespring.traces import TraceFit as TraceFit
    from telespring.traces import TraceStatistics as TraceStatistics
    from telespring.traces import assess_trace as assess_trace
    from telespring.traces import read_trace as read_trace
else:
    # Hidden from type checkers, which would accept every name.
    # Importing matplotlib takes long, so `plot` waits until it is used. So does all that runs trials or reads
    # files: half of the package, without which the criteria are there at once.
    __getattr__ = old_names(
        __name__,
        submodules=("plot",),
        late={
            "Answer": "telespring.answer",
            "BidsExport": "telespring.exchange",
            "BurstFit": "telespring.traces",
            "Comparison": "telespring.comparison",
            "JitterFit": "telespring.traces",
            "MissingRows": "telespring.traces",
            "PlayedTrace": "telespring.traces",
            "PlayoutChoice": "telespring.traces",
            "RecordedWay": "telespring.traces",
            "Replay": "telespring.replays",
            "SessionRecording": "telespring.recording",
            "SiteRecording": "telespring.replays",
            "Trace": "telespring.traces",
            "TraceAssessment": "telespring.traces",
            "TraceEvidence": "telespring.traces",
            "TraceFit": "telespring.traces",
            "TraceStatistics": "telespring.traces",
            "analyse_recording": "telespring.analysis.sessions",
            "assess_trace": "telespring.traces",
            "compare": "telespring.comparison",
            "decide": "telespring.answer",
            "explore": "telespring.app.widget",
            "export_bids": "telespring.exchange",
            "export_mat": "telespring.exchange",
            "merge_recordings": "telespring.recording",
            "merge_shards": "telespring.sweeps",
            "merge_surveys": "telespring.sweeps",
            "read_recording": "telespring.recording",
            "read_trace": "telespring.traces",
            "rehearse": "telespring.rehearsal",
            "replay": "telespring.replays",
            "survey_dyads": "telespring.sweeps",
            "sweep": "telespring.sweeps",
            "unsafe_quantile": "telespring.sweeps",
        },
    )


def __dir__() -> list[str]:
    return sorted([*__all__, "plot"])
