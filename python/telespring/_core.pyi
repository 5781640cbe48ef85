# What crates/telespring-py compiles to; a test compares the two.

from collections.abc import Callable, Iterator, Mapping, Sequence
from os import PathLike
from typing import Any, ClassVar, Final, Literal, TypeAlias, TypedDict, final, overload

import numpy as np
from numpy.typing import ArrayLike, NDArray

from telespring._types import (
    Assumption,
    ComplexArray,
    Delay,
    DelayValue,
    FloatArray,
    GridStatus,
    Method,
    NyquistStatus,
    OptionValues,
    PerAxis,
    PredictorChoice,
    SampledCertificate,
    SolverStatus,
    Status,
    Tier,
    TraceFormat,
    Unavailable,
)

__all__ = [
    "LEAST_PROBABILITY",
    "LONGEST_DELAY",
    "POPULATION_BIN_RATIO",
    "RESERVE",
    "SOFTEST",
    "STIFFEST",
    "WITHIN",
    "Adversary",
    "Agent",
    "Architecture",
    "Arm",
    "AxisTier",
    "AxisVerdict",
    "BurstFit",
    "ComparisonPlan",
    "Condition",
    "Coupling",
    "Crossing",
    "Decision",
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
    "HandleMotion",
    "HeldCoupling",
    "JitterFit",
    "JudgedNetwork",
    "Knowledge",
    "Laboratory",
    "LaboratorySettings",
    "Network",
    "NoiseFit",
    "Nyquist",
    "Operator",
    "OperatorPoint",
    "OperatorRange",
    "PaperVerdict",
    "PlayedTrace",
    "Question",
    "RecordedSite",
    "Recording",
    "Recordings",
    "Remedies",
    "ReplayedSite",
    "ResponseCurve",
    "Robot",
    "RobotRecord",
    "SampledSpectrum",
    "Spectrum",
    "StiffnessAllowed",
    "StiffnessMargin",
    "Study",
    "Task",
    "Trace",
    "TraceFit",
    "TraceStatistics",
    "Uncertainty",
    "VaryingDelay",
    "Verdict",
    "Verdicts",
    "__version__",
    "arm_operator",
    "certified_roots",
    "characteristic_roots",
    "check_usual",
    "constant_delay",
    "critical_stiffness",
    "cross_inertia",
    "crossings",
    "decay_stiffness",
    "delay_limit",
    "fit_noise",
    "frequency_grid",
    "frequency_response",
    "hman",
    "is_axis_stable",
    "is_instability_proven",
    "is_stable",
    "is_stable_over_delays",
    "is_stable_over_stiffnesses",
    "is_within",
    "maximum_delay",
    "maximum_stiffness",
    "minimum_damping",
    "mobility_matrix",
    "nyquist",
    "open_loop",
    "partner_response",
    "pose_stability",
    "pose_system",
    "predict_motion",
    "replay_pair",
    "replay_site",
    "robot_record",
    "simulate",
    "simulate_handle",
    "solve_dde",
    "spectral_abscissa",
    "stability_map",
    "stable_delays",
    "stiffness_limit",
    "tally_population",
    "tier_stiffness_limit",
    "transfer_matrix",
    "trial_seed",
    "unstable_root_count",
    "usual_range",
    "verdicts",
    "worst_status",
]

__version__: Final[str]
# a stable dyad whose robots have errors is marginal with a smaller probability
LEAST_PROBABILITY: Final[float]
# the longest one-way delay that is accepted, s
LONGEST_DELAY: Final[float]
# the share of stiffness and of delay that a stable dyad keeps; with less it is marginal
RESERVE: Final[float]
# the softest and the stiffest spring that is accepted, N/m
SOFTEST: Final[float]
STIFFEST: Final[float]
# a factor that keeps rounding on the safe side of a limit
WITHIN: Final[float]

# what a response is of: the dyad, the stiffness (N/m), the delay, the axis
_Loop: TypeAlias = tuple[Dyad, float, Delay, int | str]

# per axis the approximation error for each robot, and whether all are small
_Fits: TypeAlias = tuple[list[list[float]], bool]

_A: TypeAlias = ArrayLike
_First: TypeAlias = ArrayLike | Dyad | DyadAxis

_Ages: TypeAlias = tuple[tuple[float, float], tuple[float, float]]

class _Record:
    def to_dict(self) -> dict[str, Any]: ...
    def _repr_html_(self) -> str: ...
    def __eq__(self, value: object, /) -> bool: ...
    def __ne__(self, value: object, /) -> bool: ...
    def __hash__(self) -> int: ...
    def __getnewargs__(self) -> tuple[Any, ...]: ...

class _TupleRecord(_Record):
    def __len__(self) -> int: ...
    def __getitem__(self, key: int, /) -> float: ...
    def __iter__(self) -> Iterator[float]: ...

@final
class Robot:
    def __new__(cls, mass: PerAxis, damping: PerAxis, axes: Sequence[str] | None = None) -> Robot: ...
    @property
    def mass(self) -> FloatArray: ...
    @property
    def damping(self) -> FloatArray: ...
    @property
    def axes(self) -> list[str]: ...
    def __eq__(self, value: object, /) -> bool: ...
    def __ne__(self, value: object, /) -> bool: ...
    def to_dict(self) -> dict[str, Any]: ...
    def _repr_html_(self) -> str: ...
    def __hash__(self) -> int: ...
    def __getnewargs__(self) -> tuple[list[float], list[float], list[str]]: ...

@final
class Operator:
    def __new__(cls, mass: PerAxis = 0.0, damping: PerAxis = 0.0, stiffness: PerAxis = 0.0) -> Operator: ...
    @property
    def mass(self) -> FloatArray: ...
    @property
    def damping(self) -> FloatArray: ...
    @property
    def stiffness(self) -> FloatArray: ...
    def __eq__(self, value: object, /) -> bool: ...
    def __ne__(self, value: object, /) -> bool: ...
    def __hash__(self) -> int: ...
    def __getnewargs__(
        self,
    ) -> tuple[float | list[float], float | list[float], float | list[float]]: ...

@final
class Dyad:
    def __new__(
        cls,
        robot1: Robot,
        robot2: Robot,
        operators: Sequence[Operator | None] | None = None,
        coupling_damping: float = 0.0,
    ) -> Dyad: ...
    @property
    def robots(self) -> tuple[Robot, Robot]: ...
    @property
    def operators(self) -> tuple[Operator, Operator]: ...
    @property
    def coupling_damping(self) -> float: ...
    @property
    def axes(self) -> list[str]: ...
    def __eq__(self, value: object, /) -> bool: ...
    def __ne__(self, value: object, /) -> bool: ...
    def to_dict(self) -> dict[str, Any]: ...
    def _repr_html_(self) -> str: ...
    def __hash__(self) -> int: ...
    def __getnewargs__(self) -> tuple[Robot, Robot, tuple[Operator, Operator], float]: ...
    def delay_system(
        self, stiffness: float, delay: Delay, axis: int | str = 0, *, predictor: PredictorChoice = "hold"
    ) -> DelaySystem: ...
    def axis(self, axis: int | str) -> DyadAxis: ...
    def __getitem__(self, key: int | str, /) -> DyadAxis: ...
    def __len__(self) -> int: ...
    def __iter__(self) -> Iterator[DyadAxis]: ...
    def __contains__(self, name: str, /) -> bool: ...

class _Keywords(TypedDict):
    kh1: float
    kh2: float
    c: float

@final
class DyadAxis:
    def __new__(
        cls,
        m1: float,
        b1: float,
        m2: float,
        b2: float,
        *,
        kh1: float = 0.0,
        kh2: float = 0.0,
        c: float = 0.0,
        name: str = "x",
        index: int = 0,
    ) -> DyadAxis: ...
    name: Final[str]
    index: Final[int]
    masses: Final[tuple[float, float]]
    dampings: Final[tuple[float, float]]
    ground_stiffness: Final[tuple[float, float]]
    coupling_damping: Final[float]
    parameters: Final[tuple[float, float, float, float]]
    keywords: Final[_Keywords]
    is_plain: Final[bool]
    def critical_stiffness(self, method: Method = "exact") -> float: ...
    @overload
    def maximum_delay(self, k: float, method: Method = "exact") -> float: ...
    @overload
    def maximum_delay(self, k: Sequence[float] | FloatArray, method: Method = "exact") -> FloatArray: ...
    @overload
    def maximum_stiffness(self, delay: float) -> float: ...
    @overload
    def maximum_stiffness(self, delay: Sequence[float] | FloatArray) -> FloatArray: ...
    @overload
    def minimum_damping(self, k: float, delay: float) -> float: ...
    @overload
    def minimum_damping(self, k: ArrayLike, delay: ArrayLike) -> float | FloatArray: ...
    @overload
    def unstable_root_count(self, k: float, delay: float) -> int: ...
    @overload
    def unstable_root_count(self, k: ArrayLike, delay: ArrayLike) -> int | NDArray[np.int64]: ...
    @overload
    def is_stable(self, k: float, delay: float) -> bool: ...
    @overload
    def is_stable(self, k: ArrayLike, delay: ArrayLike) -> bool | NDArray[np.bool_]: ...
    def stability_map(self, k: ArrayLike, delay: ArrayLike) -> NDArray[np.bool_]: ...
    def crossings(self, k: float) -> list[Crossing]: ...
    def sampled_stable_delays(
        self,
        k: float,
        sample_period: float,
        computing_time: float = 0.0,
        delay: Delay = 0.0,
        horizon: float = 100.0,
    ) -> list[tuple[float, float]]: ...
    def stable_delays(self, k: float, horizon: float = 100.0) -> list[tuple[float, float]]: ...
    def age_range_stiffness(
        self, forward: tuple[float, float], backward: tuple[float, float] | None = None
    ) -> float: ...
    def decay_stiffness(self, delay: float, decay_rate: float) -> list[tuple[float, float]]: ...
    def spectral_abscissa(self, k: float, delay: Delay) -> float: ...
    def characteristic_roots(self, k: float, delay: Delay, count: int = 8) -> ComplexArray: ...
    def certified_roots(self, k: float, delay: Delay, count: int = 8) -> Spectrum: ...
    def to_dict(self) -> dict[str, Any]: ...
    def __eq__(self, value: object, /) -> bool: ...
    def __ne__(self, value: object, /) -> bool: ...
    def __hash__(self) -> int: ...
    def __getnewargs_ex__(self) -> tuple[tuple[float, float, float, float], dict[str, Any]]: ...

@final
class Crossing(_TupleRecord):
    def __new__(cls, delay: float, frequency: float, direction: int) -> Crossing: ...
    delay: Final[float]
    frequency: Final[float]
    direction: Final[int]

@final
class Spectrum(_Record):
    def __new__(
        cls, roots: ComplexArray, rigid_body: bool, complete: bool, certificate: str, depth: float
    ) -> Spectrum: ...
    roots: Final[ComplexArray]
    rigid_body: Final[bool]
    complete: Final[bool]
    certificate: Final[str]
    depth: Final[float]

@final
class NoiseFit(_Record):
    def __new__(
        cls, model: str, process: float, position: float, log_likelihood: float, end: str
    ) -> NoiseFit: ...
    model: Final[str]
    process: Final[float]
    position: Final[float]
    log_likelihood: Final[float]
    end: Final[str]

@final
class Coupling:
    def __new__(cls, stiffness: float, damping: float = 0.0) -> Coupling: ...
    @property
    def stiffness(self) -> float: ...
    @property
    def damping(self) -> float: ...
    def __eq__(self, value: object, /) -> bool: ...
    def __ne__(self, value: object, /) -> bool: ...
    def __hash__(self) -> int: ...
    def __getnewargs__(self) -> tuple[float, float]: ...

@final
class Network:
    def __new__(
        cls,
        delay: Delay,
        jitter: Delay = 0.0,
        max_gap: float = 0.0,
        sample_period: float = 0.0,
        computing_time: float = 0.0,
    ) -> Network: ...
    @property
    def delay(self) -> tuple[float, float]: ...
    @property
    def jitter(self) -> float: ...
    @property
    def jitters(self) -> tuple[float, float]: ...
    @property
    def max_gap(self) -> float: ...
    @property
    def sample_period(self) -> float: ...
    @property
    def computing_time(self) -> float: ...
    @property
    def is_constant(self) -> bool: ...
    @property
    def oldest_partner_sample(self) -> tuple[float, float]: ...
    @property
    def oldest_own_sample(self) -> float: ...
    @property
    def buffered(self) -> tuple[float, float]: ...
    def __eq__(self, value: object, /) -> bool: ...
    def __ne__(self, value: object, /) -> bool: ...
    def to_dict(self) -> dict[str, Any]: ...
    def _repr_html_(self) -> str: ...
    def __hash__(self) -> int: ...
    def __getnewargs__(
        self,
    ) -> tuple[tuple[float, float], tuple[float, float], float, float, float]: ...

@final
class OperatorRange:
    def __new__(cls, low: Operator, high: Operator) -> OperatorRange: ...
    @property
    def low(self) -> Operator: ...
    @property
    def high(self) -> Operator: ...
    def __eq__(self, value: object, /) -> bool: ...
    def __ne__(self, value: object, /) -> bool: ...
    def __hash__(self) -> int: ...
    def __getnewargs__(self) -> tuple[Operator, Operator]: ...

# Robot files of both sides, or their texts; None keeps the study's own.
_RobotFiles: TypeAlias = tuple[str | PathLike[str] | None, str | PathLike[str] | None]

@final
class Study:
    @staticmethod
    def paper() -> Study: ...
    @staticmethod
    def from_toml(text: str, robots: _RobotFiles = (None, None), **sections: object) -> Study: ...
    @staticmethod
    def read(path: str | PathLike[str], robots: _RobotFiles = (None, None), **sections: object) -> Study: ...
    def replace(self, **sections: object) -> Study: ...
    def with_robot(self, side: int, robot_file: str | PathLike[str]) -> Study: ...
    @property
    def names_arms_or_agents(self) -> bool: ...
    def to_toml(self) -> str: ...
    @property
    def name(self) -> str: ...
    @property
    def robot_names(self) -> tuple[str | None, str | None]: ...
    @property
    def dyad(self) -> Dyad: ...
    @property
    def operator_ranges(self) -> tuple[OperatorRange, OperatorRange] | None: ...
    @property
    def coupling(self) -> Coupling: ...
    @property
    def stiffness(self) -> float: ...
    @property
    def has_stiffness(self) -> bool: ...
    @property
    def network(self) -> Network: ...
    @property
    def delay(self) -> tuple[float, float]: ...
    @property
    def has_delay(self) -> bool: ...
    @property
    def adversaries(self) -> tuple[Adversary | None, Adversary | None]: ...
    @property
    def has_playout_buffer(self) -> bool: ...
    @property
    def trace_files(self) -> tuple[str | None, str | None]: ...
    def judged_network(
        self, delay: Delay | None = None, traces: tuple[str | None, str | None] = (None, None)
    ) -> JudgedNetwork: ...
    @property
    def uncertainty(self) -> tuple[Uncertainty | None, Uncertainty | None]: ...
    @property
    def least_mass(self) -> FloatArray: ...
    @property
    def least_damping(self) -> FloatArray: ...
    @property
    def coulomb(self) -> FloatArray: ...
    @property
    def ground_stiffness(self) -> FloatArray: ...
    @property
    def experiment(self) -> Experiment | None: ...
    @property
    def session(self) -> Architecture: ...
    def guard_overdraft(self, stiffness: float) -> GuardOverdraft: ...
    @property
    def comparison(self) -> ComparisonPlan: ...
    def __eq__(self, value: object, /) -> bool: ...
    def __ne__(self, value: object, /) -> bool: ...
    def _repr_html_(self) -> str: ...
    def __hash__(self) -> int: ...
    def __reduce__(self) -> tuple[Callable[[str], Study], tuple[str]]: ...

@final
class Uncertainty:
    def __new__(
        cls, mass_sd: Sequence[float], damping_sd: Sequence[float], correlation: Sequence[float]
    ) -> Uncertainty: ...
    @property
    def mass_sd(self) -> FloatArray: ...
    @property
    def damping_sd(self) -> FloatArray: ...
    @property
    def correlation(self) -> FloatArray: ...
    def __eq__(self, value: object, /) -> bool: ...
    def __ne__(self, value: object, /) -> bool: ...
    def __hash__(self) -> int: ...
    def __getnewargs__(self) -> tuple[list[float], list[float], list[float]]: ...

@final
class Adversary:
    def __new__(cls, **keys: object) -> Adversary: ...
    @property
    def kind(
        self,
    ) -> Literal["oldest-sample", "most-harmful-sample", "stretch-timed", "lying-peer"]: ...
    @property
    def memory(self) -> float | None: ...
    @property
    def longest(self) -> float | None: ...
    @property
    def position(self) -> float | None: ...
    @property
    def stamp(self) -> float | None: ...
    @property
    def power(self) -> float | None: ...
    def to_dict(self) -> dict[str, Any]: ...
    def __eq__(self, value: object, /) -> bool: ...
    def __ne__(self, value: object, /) -> bool: ...
    def __hash__(self) -> int: ...
    def __getnewargs_ex__(self) -> tuple[tuple[()], dict[str, Any]]: ...

@final
class Agent:
    def __new__(cls, **keys: object) -> Agent: ...
    @property
    def kind(self) -> Literal["skilled", "blurred", "python"]: ...
    @property
    def stiffness(self) -> float | None: ...
    @property
    def damping(self) -> float | None: ...
    @property
    def spots(self) -> int | None: ...
    @property
    def spot_velocity(self) -> float | None: ...
    @property
    def spot_lifetime(self) -> float | None: ...
    @property
    def class_(self) -> str | None: ...
    @property
    def options(self) -> dict[str, Any] | None: ...
    def to_dict(self) -> dict[str, Any]: ...
    def __getitem__(self, key: str, /) -> Any: ...
    def __eq__(self, value: object, /) -> bool: ...
    def __ne__(self, value: object, /) -> bool: ...
    def __hash__(self) -> int: ...
    def __getnewargs_ex__(self) -> tuple[tuple[()], dict[str, Any]]: ...

@final
class Arm:
    def __new__(cls, **keys: object) -> Arm: ...
    @property
    def kind(self) -> Literal["massless", "lumped", "two-link"]: ...
    @property
    def mass(self) -> tuple[float, float] | None: ...
    @property
    def damping(self) -> tuple[float, float] | None: ...
    @property
    def base(self) -> tuple[float, float] | None: ...
    @property
    def elbow(self) -> Literal["left", "right"] | None: ...
    @property
    def link_length(self) -> tuple[float, float] | None: ...
    @property
    def link_mass(self) -> tuple[float, float] | None: ...
    @property
    def link_centre(self) -> tuple[float, float] | None: ...
    @property
    def link_inertia(self) -> tuple[float, float] | None: ...
    @property
    def joint_damping(self) -> tuple[float, float] | None: ...
    @property
    def rotor_inertia(self) -> tuple[float, float] | None: ...
    @property
    def torque_limit(self) -> tuple[float, float] | None: ...
    def to_dict(self) -> dict[str, Any]: ...
    def __getitem__(self, key: str, /) -> Any: ...
    def __eq__(self, value: object, /) -> bool: ...
    def __ne__(self, value: object, /) -> bool: ...
    def __hash__(self) -> int: ...
    def __getnewargs_ex__(self) -> tuple[tuple[()], dict[str, Any]]: ...

@final
class Task:
    def __new__(cls, **keys: object) -> Task: ...
    @property
    def kind(self) -> Literal["figure-eight", "python"]: ...
    @property
    def amplitude(self) -> tuple[float, float] | None: ...
    @property
    def angular_frequency(self) -> float | None: ...
    @property
    def function(self) -> str | None: ...
    @property
    def options(self) -> dict[str, Any] | None: ...
    def positions(self, times: Sequence[float] | FloatArray) -> FloatArray: ...
    def to_dict(self) -> dict[str, Any]: ...
    def __getitem__(self, key: str, /) -> Any: ...
    def __eq__(self, value: object, /) -> bool: ...
    def __ne__(self, value: object, /) -> bool: ...
    def __hash__(self) -> int: ...
    def __getnewargs_ex__(self) -> tuple[tuple[()], dict[str, Any]]: ...

@final
class Condition(_Record):
    def __new__(cls, stiffness: float | None, delay: float) -> Condition: ...
    stiffness: Final[float | None]
    delay: Final[float]
    def __len__(self) -> int: ...
    def __getitem__(self, key: int, /) -> Any: ...
    def __iter__(self) -> Iterator[Any]: ...

@final
class JudgedNetwork(_Record):
    def __new__(
        cls,
        network: Network,
        has_playout_buffer: bool,
        is_as_stated: bool,
        ages: _Ages | None,
        lasting: tuple[tuple[float, float], ...],
        sources: tuple[str, ...],
        unjudged: tuple[str, ...],
        has_computing_tick: bool,
        is_guard_predicted: bool,
    ) -> JudgedNetwork: ...
    @property
    def network(self) -> Network: ...
    @property
    def has_playout_buffer(self) -> bool: ...
    @property
    def is_as_stated(self) -> bool: ...
    @property
    def ages(self) -> _Ages | None: ...
    @property
    def lasting(self) -> tuple[tuple[float, float], ...]: ...
    @property
    def sources(self) -> tuple[str, ...]: ...
    @property
    def unjudged(self) -> tuple[str, ...]: ...
    @property
    def has_computing_tick(self) -> bool: ...
    @property
    def is_guard_predicted(self) -> bool: ...

@final
class HeldCoupling(_Record):
    def __new__(
        cls, stiffness: float, damping: tuple[tuple[float, float], tuple[float, float]]
    ) -> HeldCoupling: ...
    stiffness: Final[float]
    damping: Final[tuple[tuple[float, float], tuple[float, float]]]

@final
class LaboratorySettings(_Record):
    def __new__(
        cls,
        computing_tick: bool,
        actuator_lag: float,
        encoder_resolution: float,
        jitter: float,
        loss: float,
    ) -> LaboratorySettings: ...
    computing_tick: Final[bool]
    actuator_lag: Final[float]
    encoder_resolution: Final[float]
    jitter: Final[float]
    loss: Final[float]

@final
class Architecture:
    def __new__(cls, **keys: object) -> Architecture: ...
    @property
    def strategy(
        self,
    ) -> Literal[
        "spring",
        "guard",
        "injected-damping",
        "wave-variables",
        "time-domain-passivity",
        "two-layer",
        "set-position-modulation",
    ]: ...
    @property
    def predictor(self) -> Literal["hold", "linear", "kalman", "shared-target"]: ...
    @property
    def playout(self) -> Literal["fixed", "adaptive"]: ...
    @property
    def playout_delay(self) -> float | None: ...
    @property
    def label(self) -> str: ...
    @property
    def has_account(self) -> bool: ...
    @property
    def guard_settings(self) -> tuple[float, float, float] | None: ...
    def settings(self) -> dict[str, Any]: ...
    def to_dict(self) -> dict[str, Any]: ...
    def __eq__(self, value: object, /) -> bool: ...
    def __ne__(self, value: object, /) -> bool: ...
    def __hash__(self) -> int: ...
    def __getnewargs_ex__(self) -> tuple[tuple[()], dict[str, Any]]: ...

@final
class GuardOverdraft(_Record):
    def __new__(cls, ratio: float, hidden: float, proven_stiffness: float) -> GuardOverdraft: ...
    ratio: Final[float]
    hidden: Final[float]
    proven_stiffness: Final[float]
    LARGEST_PROVEN_RATIO: ClassVar[float]
    @property
    def is_proven(self) -> bool: ...
    def largest_energy(self, available: float) -> float: ...

@final
class ComparisonPlan:
    @property
    def architectures(self) -> list[Architecture]: ...
    @property
    def labels(self) -> list[str]: ...
    @property
    def networks(self) -> list[tuple[str, dict[str, Any], list[float] | None]]: ...
    def __eq__(self, value: object, /) -> bool: ...
    def __ne__(self, value: object, /) -> bool: ...
    def __hash__(self) -> int: ...
    def __reduce__(self) -> tuple[Callable[[str], ComparisonPlan], tuple[str]]: ...

@final
class Experiment:
    @property
    def conditions(self) -> tuple[Condition, ...]: ...
    @property
    def trials(self) -> int: ...
    @property
    def duration(self) -> float: ...
    @property
    def discard(self) -> float: ...
    @property
    def record_rate(self) -> float: ...
    @property
    def seed(self) -> int: ...
    @property
    def order(self) -> Literal["blocks", "shuffled"]: ...
    @property
    def sample_period(self) -> float: ...
    @property
    def tick_count(self) -> int: ...
    @property
    def tick_stride(self) -> int: ...
    @property
    def sample_times(self) -> FloatArray: ...
    @property
    def agents(self) -> tuple[Agent, Agent]: ...
    @property
    def task(self) -> Task: ...
    @property
    def arms(self) -> tuple[Arm, Arm]: ...
    @property
    def settings(self) -> LaboratorySettings: ...
    @property
    def coupling_damping(self) -> float: ...
    def held_coupling(self, stiffness: float, delay: Delay) -> HeldCoupling: ...
    @property
    def laboratory(self) -> Laboratory: ...
    @property
    def trace_files(self) -> tuple[str | None, str | None]: ...
    def laboratory_on(self, traces: tuple[str | None, str | None]) -> Laboratory: ...
    def __eq__(self, value: object, /) -> bool: ...
    def __ne__(self, value: object, /) -> bool: ...
    def __hash__(self) -> int: ...
    def __reduce__(self) -> tuple[Callable[[str], Experiment], tuple[str]]: ...

@final
class RobotRecord(_Record):
    def __new__(
        cls,
        independent: bool | None,
        warnings: tuple[str, ...],
        logs: int | None,
        stiffness: tuple[float, ...] | None,
    ) -> RobotRecord: ...
    independent: Final[bool | None]
    warnings: Final[tuple[str, ...]]
    logs: Final[int | None]
    stiffness: Final[tuple[float, ...] | None]

@final
class DelaySystem:
    def __new__(cls, a0: ArrayLike, delayed: Sequence[tuple[float, ArrayLike]] = ()) -> DelaySystem: ...
    @property
    def a0(self) -> FloatArray: ...
    @property
    def delayed(self) -> list[tuple[float, FloatArray]]: ...
    def characteristic_roots(self, count: int = 8) -> ComplexArray: ...
    def spectral_abscissa(self) -> float: ...
    def spectral_abscissa_without_zero(self) -> float: ...
    @property
    def roots_at_zero(self) -> int: ...
    def certified_roots(self, count: int = 8) -> Spectrum: ...
    def __eq__(self, value: object, /) -> bool: ...
    def __ne__(self, value: object, /) -> bool: ...
    def __hash__(self) -> int: ...
    def __getnewargs__(self) -> tuple[FloatArray, list[tuple[float, FloatArray]]]: ...

@final
class OperatorPoint(_Record):
    def __new__(cls, mass: float, damping: float, stiffness: float) -> OperatorPoint: ...
    mass: Final[float]
    damping: Final[float]
    stiffness: Final[float]

@final
class StiffnessMargin(_Record):
    def __new__(cls, ratio: float, difference: float) -> StiffnessMargin: ...
    ratio: Final[float]
    difference: Final[float]

@final
class Verdict(_Record):
    def __new__(
        cls,
        tier: Tier,
        stiffness_bound: float | None,
        attained: bool,
        satisfied: bool,
        proven: bool,
        least_found: float | None,
        margin: StiffnessMargin | None,
        worst_axis: int | None,
        worst_operators: tuple[OperatorPoint, OperatorPoint] | None,
        assumption: Assumption | tuple[float, float],
        unavailable: Unavailable | None,
        ages: tuple[tuple[float, float], tuple[float, float]] | None,
        attack: float | None,
    ) -> Verdict: ...
    tier: Final[Tier]
    stiffness_bound: Final[float | None]
    attained: Final[bool]
    satisfied: Final[bool]
    proven: Final[bool]
    least_found: Final[float | None]
    margin: Final[StiffnessMargin | None]
    worst_axis: Final[int | None]
    worst_operators: Final[tuple[OperatorPoint, OperatorPoint] | None]
    assumption: Final[Assumption]
    unavailable: Final[Unavailable | None]
    ages: Final[tuple[tuple[float, float], tuple[float, float]] | None]
    attack: Final[float | None]
    buffer_delay: Final[tuple[float, float] | None]
    assumption_met: Final[bool]

@final
class StiffnessAllowed(_Record):
    def __new__(cls, stiffness: float, attained: bool, tier: Tier) -> StiffnessAllowed: ...
    stiffness: Final[float]
    attained: Final[bool]
    tier: Final[Tier]

@final
class PaperVerdict(_Record):
    def __new__(
        cls,
        critical_stiffness: float,
        critical_axis: int,
        maximum_delay: float,
        delay_axis: int,
        stable: bool,
        agrees: bool,
    ) -> PaperVerdict: ...
    critical_stiffness: Final[float]
    critical_axis: Final[int]
    maximum_delay: Final[float]
    delay_axis: Final[int]
    stable: Final[bool]
    agrees: Final[bool]

@final
class DelayBudget(_Record):
    def __new__(
        cls, network: float, jitter: float, gap: float, sampling: float, computing: float
    ) -> DelayBudget: ...
    network: Final[float]
    jitter: Final[float]
    gap: Final[float]
    sampling: Final[float]
    computing: Final[float]
    total: Final[float]

@final
class SampledSpectrum(_Record):
    def __new__(
        cls, radius: float, abscissa_equivalent: float, frequency: float, certificate: SampledCertificate
    ) -> SampledSpectrum: ...
    radius: Final[float]
    abscissa_equivalent: Final[float]
    frequency: Final[float]
    certificate: Final[SampledCertificate]
    stable: Final[bool]

@final
class AxisTier(_Record):
    def __new__(
        cls,
        tier: Tier,
        stiffness_bound: float | None,
        attained: bool,
        satisfied: bool,
        proven: bool,
        least_found: float | None,
        operators: tuple[OperatorPoint, OperatorPoint],
        unavailable: Unavailable | None,
    ) -> AxisTier: ...
    tier: Final[Tier]
    stiffness_bound: Final[float | None]
    attained: Final[bool]
    satisfied: Final[bool]
    proven: Final[bool]
    least_found: Final[float | None]
    operators: Final[tuple[OperatorPoint, OperatorPoint]]
    unavailable: Final[Unavailable | None]

@final
class AxisVerdict(_Record):
    def __new__(
        cls,
        name: str,
        grounded: bool,
        tiers: tuple[AxisTier, ...],
        paper_critical_stiffness: float,
        paper_maximum_delay: float,
        maximum_delay: float,
        maximum_delay_proven: bool,
        least_maximum_delay: float,
        sampled: SampledSpectrum | None,
        sampled_stiffness_bound: float | None,
        sampled_stable: bool | None,
        sampled_proven: bool | None,
    ) -> AxisVerdict: ...
    name: Final[str]
    grounded: Final[bool]
    tiers: Final[tuple[AxisTier, ...]]
    paper_critical_stiffness: Final[float]
    paper_maximum_delay: Final[float]
    maximum_delay: Final[float]
    maximum_delay_proven: Final[bool]
    least_maximum_delay: Final[float]
    sampled: Final[SampledSpectrum | None]
    sampled_stiffness_bound: Final[float | None]
    sampled_stable: Final[bool | None]
    sampled_proven: Final[bool | None]

@final
class DelayLimit(_Record):
    def __new__(
        cls, delay: float, attained: bool, proven: bool, least_found: float, worst_axis: int
    ) -> DelayLimit: ...
    delay: Final[float]
    attained: Final[bool]
    proven: Final[bool]
    least_found: Final[float]
    worst_axis: Final[int]

@final
class Remedies(_Record):
    def __new__(cls, stiffness: float | None, delay: float | None, damping: float | None) -> Remedies: ...
    stiffness: Final[float | None]
    delay: Final[float | None]
    damping: Final[float | None]

@final
class Verdicts(_Record):
    def __new__(
        cls,
        stiffness: float,
        network: Network,
        tiers: tuple[Verdict, ...],
        any_passive_operator: float | None,
        sampled_stable: bool | None,
        sampled_proven: bool | None,
        paper: PaperVerdict,
        stiffness_allowed: StiffnessAllowed | None,
        stiffness_allowed_behind_buffer: StiffnessAllowed | None,
        delay_budget: tuple[DelayBudget, DelayBudget],
        axes: tuple[AxisVerdict, ...],
        remedies: Remedies,
    ) -> Verdicts: ...
    stiffness: Final[float]
    network: Final[Network]
    tiers: Final[tuple[Verdict, ...]]
    any_passive_operator: Final[float | None]
    sampled_stable: Final[bool | None]
    sampled_proven: Final[bool | None]
    paper: Final[PaperVerdict]
    stiffness_allowed: Final[StiffnessAllowed | None]
    stiffness_allowed_behind_buffer: Final[StiffnessAllowed | None]
    delay_budget: Final[tuple[DelayBudget, DelayBudget]]
    axes: Final[tuple[AxisVerdict, ...]]
    remedies: Final[Remedies]
    def tier(self, name: Tier) -> Verdict: ...

@final
class FrequencyResponse(_Record):
    def __new__(
        cls,
        frequency: FloatArray,
        value: ComplexArray,
        magnitude: FloatArray,
        phase: FloatArray,
        poles_on_axis: tuple[float, ...],
    ) -> FrequencyResponse: ...
    frequency: Final[FloatArray]
    value: Final[ComplexArray]
    magnitude: Final[FloatArray]
    phase: Final[FloatArray]
    poles_on_axis: Final[tuple[float, ...]]

@final
class ResponseCurve(_Record):
    def __new__(
        cls, frequency: FloatArray, value: ComplexArray, magnitude: FloatArray, phase: FloatArray
    ) -> ResponseCurve: ...
    frequency: Final[FloatArray]
    value: Final[ComplexArray]
    magnitude: Final[FloatArray]
    phase: Final[FloatArray]

@final
class FrequencyGrid(_Record):
    def __new__(
        cls, frequency: FloatArray, status: GridStatus, poles_on_axis: tuple[float, ...]
    ) -> FrequencyGrid: ...
    frequency: Final[FloatArray]
    status: Final[GridStatus]
    poles_on_axis: Final[tuple[float, ...]]

@final
class FrequencyMargin(_TupleRecord):
    def __new__(cls, value: float, frequency: float) -> FrequencyMargin: ...
    value: Final[float]
    frequency: Final[float]

@final
class Nyquist(_Record):
    def __new__(
        cls,
        frequency: FloatArray,
        locus: ComplexArray,
        encirclements: int,
        unstable_roots: int,
        rigid_body: bool,
        stable: bool,
        minimum_distance: FrequencyMargin,
        gain_margin: FrequencyMargin | None,
        gain_reduction_margin: FrequencyMargin | None,
        phase_margin: FrequencyMargin | None,
        delay_margin: FrequencyMargin | None,
        status: NyquistStatus,
        root_on_axis: float | None,
        locus_status: GridStatus,
        locus_poles: tuple[float, ...],
    ) -> Nyquist: ...
    frequency: Final[FloatArray]
    locus: Final[ComplexArray]
    encirclements: Final[int]
    unstable_roots: Final[int]
    rigid_body: Final[bool]
    stable: Final[bool]
    minimum_distance: Final[FrequencyMargin]
    gain_margin: Final[FrequencyMargin | None]
    gain_reduction_margin: Final[FrequencyMargin | None]
    phase_margin: Final[FrequencyMargin | None]
    delay_margin: Final[FrequencyMargin | None]
    status: Final[NyquistStatus]
    root_on_axis: Final[float | None]
    locus_status: Final[GridStatus]
    locus_poles: Final[tuple[float, ...]]

@final
class Laboratory:
    @staticmethod
    def paper() -> Laboratory: ...
    def with_robots(self, dyad: Dyad) -> Laboratory: ...
    @property
    def least_damping(self) -> tuple[tuple[float, float], tuple[float, float]]: ...
    def run(
        self,
        stiffness: float | None,
        delay: Delay,
        seed: int,
        duration: float,
        record_rate: float,
        agents: Sequence[Callable[[float, FloatArray, FloatArray, FloatArray], ArrayLike] | None]
        | None = None,
        target: ArrayLike | None = None,
        coupling_damping: float = 0.0,
        interrupt_check: Callable[[], object] | None = None,
    ) -> Recording: ...
    def target(self, duration: float, record_rate: float) -> FloatArray: ...
    def run_many(
        self,
        stiffness: Sequence[float] | FloatArray,
        delay: Sequence[float] | FloatArray,
        seed: Sequence[int] | NDArray[np.uint64],
        duration: float,
        record_rate: float,
        coupling_damping: float = 0.0,
    ) -> Recordings: ...
    def __eq__(self, value: object, /) -> bool: ...
    def __ne__(self, value: object, /) -> bool: ...
    def __hash__(self) -> int: ...

@final
class RecordedSite:
    def __new__(
        cls,
        time: NDArray[np.uint64],
        answered: NDArray[np.uint64],
        is_given: NDArray[np.bool_],
        position: ArrayLike,
        velocity: ArrayLike,
        acted: ArrayLike,
        target_position: ArrayLike,
        target_velocity: ArrayLike,
        share: ArrayLike,
        arrival_tick: NDArray[np.int64],
        arrival_time: NDArray[np.uint64],
        datagram: NDArray[np.uint8],
    ) -> RecordedSite: ...
    def __eq__(self, value: object, /) -> bool: ...
    def __ne__(self, value: object, /) -> bool: ...
    def __len__(self) -> int: ...

@final
class ReplayedSite(_Record):
    def __new__(
        cls,
        wanted: FloatArray,
        force: FloatArray,
        age: FloatArray,
        account: FloatArray,
        given_out: FloatArray,
        is_limited: NDArray[np.bool_],
        is_engaged: NDArray[np.bool_],
        limited_share: float,
        withheld_share: float,
        energy_sent: float,
        energy_received: float,
        age_mean: float,
        age_low: float,
        age_high: float,
        age_quantile_99: float,
        held_share: float,
        lost: float,
        renewed: int,
        events: Sequence[tuple[int, str, str]],
        missed_events: int,
    ) -> ReplayedSite: ...
    wanted: Final[FloatArray]
    force: Final[FloatArray]
    age: Final[FloatArray]
    account: Final[FloatArray]
    given_out: Final[FloatArray]
    is_limited: Final[NDArray[np.bool_]]
    is_engaged: Final[NDArray[np.bool_]]
    limited_share: Final[float]
    withheld_share: Final[float]
    energy_sent: Final[float]
    energy_received: Final[float]
    age_mean: Final[float]
    age_low: Final[float]
    age_high: Final[float]
    age_quantile_99: Final[float]
    held_share: Final[float]
    lost: Final[float]
    renewed: Final[int]
    events: Final[Sequence[tuple[int, str, str]]]
    missed_events: Final[int]

@final
class Recording(_Record):
    def __new__(
        cls,
        time: FloatArray,
        target: FloatArray,
        position: FloatArray,
        velocity: FloatArray,
        coupling_force: FloatArray,
        agent_force: FloatArray,
        handle_force: FloatArray,
        aim: FloatArray,
        account: FloatArray,
        age: FloatArray,
        limited_share: FloatArray,
        withheld_share: FloatArray,
        given_out: FloatArray,
        energy_sent: FloatArray,
        age_mean: FloatArray,
        age_low: FloatArray,
        age_high: FloatArray,
        held_share: FloatArray,
        lost: FloatArray,
        coupling_energy: float,
        coupling_energy_minimum: float,
        hand_energy: FloatArray,
        status: Literal["completed", "diverged", "out of reach", "too stiff"],
        ended_at: float | None,
    ) -> Recording: ...
    time: Final[FloatArray]
    target: Final[FloatArray]
    position: Final[FloatArray]
    velocity: Final[FloatArray]
    coupling_force: Final[FloatArray]
    agent_force: Final[FloatArray]
    handle_force: Final[FloatArray]
    aim: Final[FloatArray]
    account: Final[FloatArray]
    age: Final[FloatArray]
    limited_share: Final[FloatArray]
    withheld_share: Final[FloatArray]
    given_out: Final[FloatArray]
    energy_sent: Final[FloatArray]
    age_mean: Final[FloatArray]
    age_low: Final[FloatArray]
    age_high: Final[FloatArray]
    held_share: Final[FloatArray]
    lost: Final[FloatArray]
    coupling_energy: Final[float]
    coupling_energy_minimum: Final[float]
    hand_energy: Final[FloatArray]
    status: Final[Literal["completed", "diverged", "out of reach", "too stiff"]]
    ended_at: Final[float | None]

@final
class Recordings(_Record):
    def __new__(
        cls,
        time: FloatArray,
        target: FloatArray,
        position: FloatArray,
        velocity: FloatArray,
        coupling_force: FloatArray,
        agent_force: FloatArray,
        handle_force: FloatArray,
        aim: FloatArray,
        account: FloatArray,
        age: FloatArray,
        limited_share: FloatArray,
        withheld_share: FloatArray,
        given_out: FloatArray,
        energy_sent: FloatArray,
        age_mean: FloatArray,
        age_low: FloatArray,
        age_high: FloatArray,
        held_share: FloatArray,
        lost: FloatArray,
        coupling_energy: FloatArray,
        coupling_energy_minimum: FloatArray,
        hand_energy: FloatArray,
        status: tuple[Literal["completed", "diverged", "out of reach", "too stiff"], ...],
        ended_at: FloatArray,
    ) -> Recordings: ...
    time: Final[FloatArray]
    target: Final[FloatArray]
    position: Final[FloatArray]
    velocity: Final[FloatArray]
    coupling_force: Final[FloatArray]
    agent_force: Final[FloatArray]
    handle_force: Final[FloatArray]
    aim: Final[FloatArray]
    account: Final[FloatArray]
    age: Final[FloatArray]
    limited_share: Final[FloatArray]
    withheld_share: Final[FloatArray]
    given_out: Final[FloatArray]
    energy_sent: Final[FloatArray]
    age_mean: Final[FloatArray]
    age_low: Final[FloatArray]
    age_high: Final[FloatArray]
    held_share: Final[FloatArray]
    lost: Final[FloatArray]
    coupling_energy: Final[FloatArray]
    coupling_energy_minimum: Final[FloatArray]
    hand_energy: Final[FloatArray]
    status: Final[tuple[Literal["completed", "diverged", "out of reach", "too stiff"], ...]]
    ended_at: Final[FloatArray]

@final
class HandleMotion(_Record):
    def __new__(
        cls,
        position: FloatArray,
        velocity: FloatArray,
        handle_force: FloatArray,
        torque: FloatArray | None,
        status: Literal["completed", "out of reach", "too stiff"],
        ended_at: float | None,
    ) -> HandleMotion: ...
    position: Final[FloatArray]
    velocity: Final[FloatArray]
    handle_force: Final[FloatArray]
    torque: Final[FloatArray | None]
    status: Final[Literal["completed", "out of reach", "too stiff"]]
    ended_at: Final[float | None]

@final
class TraceStatistics(_Record):
    def __new__(
        cls,
        sent: int,
        interval: float,
        longest_interval: float,
        loss: float,
        burst_length: float,
        reordered: float,
        minimum: float,
        mean: float,
        sd: float,
        median: float,
        quantile_99: float,
        maximum: float,
        autocorrelation: float,
    ) -> TraceStatistics: ...
    sent: Final[int]
    interval: Final[float]
    longest_interval: Final[float]
    loss: Final[float]
    burst_length: Final[float]
    reordered: Final[float]
    minimum: Final[float]
    mean: Final[float]
    sd: Final[float]
    median: Final[float]
    quantile_99: Final[float]
    maximum: Final[float]
    autocorrelation: Final[float]

@final
class JitterFit(_Record):
    def __new__(
        cls,
        delay: float,
        jitter: float,
        kind: Literal["uniform", "normal", "gamma", "lognormal"],
        mean: float | None,
        sd: float | None,
        log_likelihood: float,
        distance: float,
    ) -> JitterFit: ...
    delay: Final[float]
    jitter: Final[float]
    kind: Final[Literal["uniform", "normal", "gamma", "lognormal"]]
    mean: Final[float | None]
    sd: Final[float | None]
    log_likelihood: Final[float]
    distance: Final[float]
    def cumulative(self, delay: ArrayLike) -> FloatArray: ...

@final
class BurstFit(_Record):
    def __new__(cls, to_bad: float, to_good: float, bursts: int, distance: float) -> BurstFit: ...
    to_bad: Final[float]
    to_good: Final[float]
    bursts: Final[int]
    distance: Final[float]

@final
class TraceFit(_Record):
    def __new__(cls, jitter: Sequence[JitterFit], burst: BurstFit | None, minimum: float) -> TraceFit: ...
    jitter: Final[tuple[JitterFit, ...]]
    burst: Final[BurstFit | None]
    minimum: Final[float]

@final
class PlayedTrace(_Record):
    def __new__(
        cls,
        delay: float,
        sample_period: float,
        ticks: int,
        held_ticks: int,
        smallest_age: float,
        largest_age: float,
        newest: FloatArray,
        oldest: FloatArray,
    ) -> PlayedTrace: ...
    delay: Final[float]
    sample_period: Final[float]
    ticks: Final[int]
    held_ticks: Final[int]
    smallest_age: Final[float]
    largest_age: Final[float]
    newest: Final[FloatArray]
    oldest: Final[FloatArray]
    @property
    def in_time(self) -> float: ...
    @property
    def ages(self) -> tuple[float, float]: ...
    def share_within(self, low: float, high: float) -> float: ...

@final
class Trace:
    def __new__(cls, time: ArrayLike, delay: ArrayLike, losses_recorded: bool | None = None) -> Trace: ...
    @staticmethod
    def _read(text: str, name: str, round_trip: bool, is_forward: bool) -> Trace: ...
    @staticmethod
    def _format(text: str) -> TraceFormat: ...
    @property
    def time(self) -> FloatArray: ...
    @property
    def delay(self) -> FloatArray: ...
    @property
    def lost(self) -> NDArray[np.bool_]: ...
    @property
    def duration(self) -> float: ...
    @property
    def losses_recorded(self) -> bool: ...
    def statistics(self) -> TraceStatistics: ...
    def quantile(self, share: float) -> float: ...
    def fit(self) -> TraceFit: ...
    def halved(self) -> Trace: ...
    def with_missing_rows(self, period: float, longest: float) -> Trace: ...
    def play(self, delay: float, sample_period: float) -> PlayedTrace: ...
    def to_csv(self) -> str: ...
    def __len__(self) -> int: ...
    def __eq__(self, value: object, /) -> bool: ...
    def __ne__(self, value: object, /) -> bool: ...
    def _repr_html_(self) -> str: ...
    def __getnewargs__(self) -> tuple[FloatArray, FloatArray, bool]: ...

# theory/criteria.pyi has their overloads
def critical_stiffness(
    m1: _First, b1: _A, m2: _A, b2: _A, method: Method = "exact", *, kh1: _A = 0.0, kh2: _A = 0.0, c: _A = 0.0
) -> Any: ...
def maximum_delay(
    m1: _First,
    b1: _A,
    m2: _A,
    b2: _A,
    k: _A,
    method: Method = "exact",
    *,
    kh1: _A = 0.0,
    kh2: _A = 0.0,
    c: _A = 0.0,
    predictor: PredictorChoice = "hold",
) -> Any: ...
def maximum_stiffness(
    m1: _First,
    b1: _A,
    m2: _A,
    b2: _A,
    delay: _A,
    *,
    kh1: _A = 0.0,
    kh2: _A = 0.0,
    c: _A = 0.0,
    predictor: PredictorChoice = "hold",
) -> Any: ...
def minimum_damping(
    m1: _First, b1: _A, m2: _A, b2: _A, k: _A, delay: _A, *, kh1: _A = 0.0, kh2: _A = 0.0, c: _A = 0.0
) -> Any: ...
def unstable_root_count(
    m1: _First,
    b1: _A,
    m2: _A,
    b2: _A,
    k: _A,
    delay: _A,
    *,
    kh1: _A = 0.0,
    kh2: _A = 0.0,
    c: _A = 0.0,
    predictor: PredictorChoice = "hold",
) -> Any: ...
def stability_map(
    m1: _First,
    b1: _A,
    m2: _A,
    b2: _A,
    k: _A,
    delay: _A,
    *,
    kh1: _A = 0.0,
    kh2: _A = 0.0,
    c: _A = 0.0,
    predictor: PredictorChoice = "hold",
) -> NDArray[np.bool_]: ...
def crossings(
    m1: _First, b1: _A, m2: _A, b2: _A, k: _A, *, kh1: _A = 0.0, kh2: _A = 0.0, c: _A = 0.0
) -> list[Crossing]: ...
def stable_delays(
    m1: _First,
    b1: _A,
    m2: _A,
    b2: _A,
    k: _A,
    horizon: _A = 100.0,
    *,
    kh1: _A = 0.0,
    kh2: _A = 0.0,
    c: _A = 0.0,
) -> list[tuple[float, float]]: ...
def decay_stiffness(
    m1: _First,
    b1: _A,
    m2: _A,
    b2: _A,
    delay: _A,
    decay_rate: _A,
    *,
    kh1: _A = 0.0,
    kh2: _A = 0.0,
    c: _A = 0.0,
) -> list[tuple[float, float]]: ...
def hman() -> Dyad: ...
def check_usual(quantity: str, field: str, value: float) -> float: ...
def usual_range(quantity: str) -> tuple[float, float]: ...
def certified_roots(
    dyad: Dyad, stiffness: float, delay: Delay, count: int = 8, axis: int | str = 0
) -> Spectrum: ...
def characteristic_roots(
    dyad: Dyad, stiffness: float, delay: Delay, count: int = 8, axis: int | str = 0
) -> ComplexArray: ...
def spectral_abscissa(dyad: Dyad, stiffness: float, delay: Delay, axis: int | str = 0) -> float: ...
def transfer_matrix(of: _Loop, s: ComplexArray, convention: str) -> ComplexArray: ...
def mobility_matrix(of: _Loop, s: ComplexArray) -> ComplexArray: ...
def frequency_response(of: _Loop, frequency: FloatArray, convention: str) -> FrequencyResponse: ...
def open_loop(of: _Loop, frequency: FloatArray) -> ResponseCurve: ...
def partner_response(of: _Loop, robot: int, frequency: FloatArray) -> ResponseCurve: ...
def frequency_grid(of: _Loop, low: float, high: float, resolution: float, limit: int) -> FrequencyGrid: ...
def nyquist(of: _Loop) -> Nyquist: ...
def verdicts(
    dyad: Dyad,
    stiffness: float,
    network: Network,
    operator_range: OperatorRange | tuple[OperatorRange, OperatorRange] | None,
    attack_seed: int | None,
) -> Verdicts: ...
def delay_limit(
    dyad: Dyad,
    stiffness: float,
    network: Network,
    operator_range: OperatorRange | tuple[OperatorRange, OperatorRange] | None,
) -> DelayLimit: ...
def is_stable_over_delays(
    dyad: Dyad,
    stiffness: float,
    network: Network,
    factors: tuple[float, float],
    operator_range: OperatorRange | tuple[OperatorRange, OperatorRange] | None,
) -> bool: ...
def is_stable_over_stiffnesses(
    dyad: Dyad,
    stiffnesses: tuple[float, float],
    network: Network,
    operator_range: OperatorRange | tuple[OperatorRange, OperatorRange] | None,
) -> bool: ...

@final
class Knowledge(_Record):
    def __new__(
        cls,
        has_coupled_axes: bool,
        stable_probability: float | None,
        varying_stiffness_limit: float | None,
        is_attack_searched: bool,
    ) -> Knowledge: ...
    has_coupled_axes: Final[bool]
    stable_probability: Final[float | None]
    varying_stiffness_limit: Final[float | None]
    is_attack_searched: Final[bool]

@final
class VaryingDelay(_Record):
    def __new__(
        cls,
        status: Status,
        stiffness_limit: float,
        is_attained: bool,
        usable_stiffness: float,
        tier: Tier | None,
        attack: float | None,
    ) -> VaryingDelay: ...
    status: Final[Status]
    stiffness_limit: Final[float]
    is_attained: Final[bool]
    usable_stiffness: Final[float]
    tier: Final[Tier | None]
    attack: Final[float | None]
    recommended_stiffness: Final[float]

@final
class Decision(_Record):
    def __new__(
        cls,
        verdicts: Verdicts,
        known: Knowledge,
        status: Status,
        constant_delay_status: Status,
        keeps_stiffness_reserve: bool,
        keeps_delay_reserve: bool,
        delay_limit: DelayLimit,
        varying: VaryingDelay | None,
    ) -> Decision: ...
    verdicts: Final[Verdicts]
    known: Final[Knowledge]
    status: Final[Status]
    constant_delay_status: Final[Status]
    keeps_stiffness_reserve: Final[bool]
    keeps_delay_reserve: Final[bool]
    delay_limit: Final[DelayLimit]
    varying: Final[VaryingDelay | None]
    is_proven: Final[bool]
    keeps_reserve: Final[bool]

@final
class Question:
    def __new__(
        cls,
        dyad: Dyad,
        network: Network,
        operator_range: OperatorRange | tuple[OperatorRange, OperatorRange] | None,
        has_playout_buffer: bool,
        robot_springs: tuple[Operator, Operator] | None,
        ages: JudgedNetwork | None,
    ) -> Question: ...
    @property
    def is_bounded(self) -> bool: ...
    @property
    def is_as_stated(self) -> bool: ...
    @property
    def is_varying(self) -> bool: ...
    @property
    def is_held(self) -> bool: ...
    def assumption(self, verdict: Verdict) -> Assumption: ...
    def allowed(self, judged: Verdicts) -> StiffnessAllowed | None: ...
    def decision(self, judged: Verdicts, known: Knowledge) -> Decision: ...
    def varying(self, judged: Verdicts, known: Knowledge) -> VaryingDelay | None: ...
    def is_usable(self, judged: Verdicts) -> bool: ...
    def delay_limit(self, judged: Verdicts) -> DelayLimit: ...
    def __eq__(self, value: object, /) -> bool: ...
    def __ne__(self, value: object, /) -> bool: ...

def is_stable(judged: Verdicts) -> bool: ...
def is_axis_stable(axis: AxisVerdict) -> bool: ...
def is_instability_proven(judged: Verdicts) -> bool: ...
def stiffness_limit(judged: Verdicts) -> float: ...
def tier_stiffness_limit(judged: Verdicts, tier: Tier) -> float | None: ...
def constant_delay(judged: Verdicts) -> tuple[float, float]: ...
def is_within(delay: float, limit: DelayLimit) -> bool: ...
def worst_status(statuses: Sequence[Status]) -> Status: ...

@final
class DelaySolution:
    status: Final[SolverStatus]
    message: Final[str]
    t: Final[FloatArray]
    y: Final[FloatArray]
    discontinuities: Final[list[tuple[float, int]]]
    steps: Final[int]
    rejected: Final[int]
    evaluations: Final[int]
    completed: Final[bool]
    start: Final[float]
    end: Final[float]
    def __call__(self, times: ArrayLike) -> FloatArray: ...
    def derivative(self, times: ArrayLike) -> FloatArray: ...
    def __reduce__(self) -> tuple[Callable[..., DelaySolution], tuple[Any, ...]]: ...

def solve_dde(
    rhs: Callable[[float, FloatArray, FloatArray], ArrayLike],
    delays: list[DelayValue],
    history: Callable[[float], ArrayLike],
    dimension: int,
    initial: list[float] | None,
    span: tuple[float, float],
    options: OptionValues,
) -> DelaySolution: ...
def trial_seed(seed: int, condition: int, trial: int) -> int: ...

POPULATION_BIN_RATIO: Final[float]

def tally_population(
    *,
    mass: tuple[float, float],
    damping: tuple[float, float],
    mass_ratio: tuple[float, float],
    damping_ratio: tuple[float, float],
    cells: tuple[int, int],
    operator_mass: float,
    operator_damping: float,
    seed: int,
    first: int,
    count: int,
) -> tuple[NDArray[np.uint64], NDArray[np.uint64], FloatArray, NDArray[np.uint64]]: ...
def simulate(
    dyad: Dyad,
    stiffness: float,
    delay: Delay,
    forces: list[list[Any]],
    duration: float,
    rate: float,
    history: list[list[Any]] | None,
    velocities: bool,
) -> tuple[FloatArray, FloatArray | None, list[float | None], _Fits, _Fits]: ...
def simulate_handle(
    handle: Mapping[str, Any],
    arm: Arm | Mapping[str, Any],
    hand_force: ArrayLike,
    robot_force: ArrayLike,
    sample_period: float,
    position0: Sequence[float],
    velocity0: Sequence[float] = ...,
) -> HandleMotion: ...
def pose_stability(
    dyad: Dyad,
    arms: tuple[Arm | Mapping[str, Any] | None, Arm | Mapping[str, Any] | None],
    stiffness: float,
    delay: Delay,
    positions: ArrayLike,
    agent_stiffness: tuple[float, float],
) -> tuple[FloatArray, FloatArray, bool]: ...
def cross_inertia(
    dyad: Dyad,
    arms: tuple[Arm | Mapping[str, Any] | None, Arm | Mapping[str, Any] | None],
    positions: ArrayLike,
) -> FloatArray: ...
def pose_system(
    dyad: Dyad,
    arms: tuple[Arm | Mapping[str, Any] | None, Arm | Mapping[str, Any] | None],
    stiffness: float,
    delay: Delay,
    position: ArrayLike,
    agent_stiffness: tuple[float, float],
) -> DelaySystem: ...
def fit_noise(times: ArrayLike, positions: ArrayLike, model: str = "constant-acceleration") -> NoiseFit: ...
def predict_motion(
    times: ArrayLike,
    positions: ArrayLike,
    velocities: ArrayLike,
    age: float,
    predictor: PredictorChoice,
    targets: tuple[ArrayLike, ArrayLike] | None = None,
) -> FloatArray: ...
def replay_site(
    study: Study,
    site: RecordedSite,
    side: int,
    session: int,
    acted_as_recorded: bool,
    largest_force: float,
    steepest_rise: float,
    silence: float,
    stall: float,
) -> ReplayedSite: ...
def replay_pair(
    study: Study,
    sites: tuple[RecordedSite, RecordedSite],
    sessions: tuple[int, int],
    acted_as_recorded: bool,
    largest_force: tuple[float, float],
    steepest_rise: tuple[float, float],
    silence: tuple[float, float],
    stall: tuple[float, float],
) -> tuple[ReplayedSite, ReplayedSite]: ...
def robot_record(robot_file: str | PathLike[str]) -> RobotRecord: ...
def arm_operator(arm: Arm | Mapping[str, Any], positions: ArrayLike) -> tuple[FloatArray, FloatArray]: ...
