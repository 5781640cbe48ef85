"""Identification of a robot from logs: mass, damping, friction and springs of each axis."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import ArrayLike

from telespring._arrays import as_number, as_numbers
from telespring._errors import InvalidInput
from telespring._types import FloatArray
from telespring.identification import diagnostics
from telespring.identification.assembly import combine_logs, identification_of
from telespring.identification.cutoff import CUTOFF_RULE, choose_cutoff, noise_deviation
from telespring.identification.glitches import without_glitches
from telespring.identification.log_checks import check_log
from telespring.identification.log_fit import FitOptions, LogFit, fit_log
from telespring.identification.resampling import even_stretches
from telespring.identification.results import METHODS, Identification, Method
from telespring.identification.stretches import Stretch
from telespring.identification.terms import AxisTerms, ModelTerms
from telespring.identification.unmodelled import estimate_inertias
from telespring.identification.warning_messages import Diagnostic

if TYPE_CHECKING:
    from telespring.identification.log_reading import Log

__all__ = ["identify", "identify_logs"]

#: An axis must travel at least so far, m, and so many times the standard deviation of its noise.
_MINIMUM_TRAVEL, _TRAVEL_PER_NOISE = 1e-3, 50.0
#: A longer lag of a force is no lag, s.
_LONGEST_DELAY = 0.2


def identify(
    time: ArrayLike,
    position: ArrayLike,
    force: ArrayLike,
    *,
    axes: Sequence[str] | None = None,
    stiffness: bool | None = None,
    coulomb: bool | None = None,
    offset: bool | None = None,
    drag: bool | None = None,
    stiction: bool | None = None,
    radius: float | None = None,
    cutoff: float | None = None,
    method: Method = "robust",
    iterations: int = 1,
    force_delay: float | None = None,
) -> Identification:
    """Estimate mass, damping, friction and a spring per axis from one log.

    F(t + τ) = m a + b v + k x + F_c sign v + F_0 is fitted to all axes, with one lag τ of the force. Velocity
    and acceleration are central differences of the positions after a zero-phase filter, which also filters
    the force. The samples are then decimated to 2.5 per period of the cut-off frequency.

    A spring to the ground, Coulomb friction, an offset and the lag are estimated unless they are ruled out:
    what no test can find would still bias mass or damping by more than their intervals. Drag, stiction and
    gravity are tested and, where the log shows them, added.

    Parameters
    ----------
    time : array_like
        s, shape (n,), increasing. Jittering time stamps are interpolated, short gaps bridged; long gaps cut
        the log into stretches.
    position : array_like
        m, shape (n,) or (n, axes).
    force : array_like
        The force that moves the robot, N, of the same shape. Measured at the handle it gives the robot
        alone; measured at the joints of an arm that moves the handle it gives robot and arm.
    axes : sequence of str
        Names of the axes; by default "x", "y", …
    stiffness, coulomb, offset : bool
        Whether the model has a spring between robot and ground, Coulomb friction, and a constant force. Each
        is in the model unless it is False.
    drag, stiction : bool
        Whether the model has a force c v|v|, and friction that is larger near rest, F_s sign v
        exp(−(v/v_s)²) (Stribeck). By default the log decides.
    radius : float
        For axes that turn: metres of travel per radian. Gravity, sine and cosine of the angle, is then tested
        too.
    cutoff : float
        Cut-off of the filter, Hz; by default chosen from the movement (`Identification.cutoff_rule`).
    method : {"robust", "ols", "paper"}
        Hampel's M-estimate; ordinary least squares; or the paper's weighted least squares, whose intervals
        are not valid (`telespring.identification.paper_reweightings`) and which fits only mass, damping and
        the terms that are True.
    iterations : int
        Number of reweightings of the paper's method; the paper prints one step and no number.
    force_delay : float
        Lag of the force's samples behind those of the position, s, where it is known; 0 if both are sampled
        together. By default it is estimated, and its uncertainty widens the interval of the mass: a lag τ
        biases the mass by about τ b.

    Returns
    -------
    Identification
        Estimates with 95 % intervals that account for autocorrelated residuals, how they were made, and
        warnings.

    Raises
    ------
    telespring.InvalidInput
        If the log cannot be used: too short, nothing moves, shapes that do not match; if it moves at one
        frequency, where a spring looks like a mass, and no `stiffness=False` rules the spring out; or if
        position noise biases mass or damping by several half-widths of their intervals at the given cut-off.

    Examples
    --------
    >>> import numpy as np
    >>> from telespring.identification import identify, paper_excitation
    >>> movement = paper_excitation()
    >>> t = np.arange(15000) / 1000.0
    >>> force = 0.8 * movement.acceleration(t) + 7.7 * movement.velocity(t)
    >>> noise = np.random.default_rng(1).normal(0.0, 0.05, t.size)
    >>> [x] = identify(t, movement.position(t), force + noise).axes
    >>> f"{x.mass.value:.2f} kg, {x.damping.value:.1f} N·s/m"
    '0.80 kg, 7.7 N·s/m'
    >>> low, high = x.mass.interval
    >>> low < 0.8 < high and high - low < 0.02
    True
    """
    options = _fit_options(
        {"stiffness": stiffness, "coulomb": coulomb, "offset": offset, "drag": drag, "stiction": stiction},
        radius,
        method,
        iterations,
        force_delay,
    )
    return _Run(time, position, force, axes, cutoff).identify(options)


def identify_logs(
    logs: Sequence[Log | tuple[ArrayLike, ArrayLike, ArrayLike]],
    *,
    axes: Sequence[str] | None = None,
    stiffness: bool | None = None,
    coulomb: bool | None = None,
    offset: bool | None = None,
    drag: bool | None = None,
    stiction: bool | None = None,
    radius: float | None = None,
    cutoff: float | None = None,
    method: Method = "robust",
    iterations: int = 1,
    force_delay: float | None = None,
) -> Identification:
    """Estimate one robot from several logs; the scatter between them enters the intervals.

    Every log is fitted by itself with the same terms: those that any of them needs. The estimates are then
    combined as random effects, with the interval of Hartung and Knapp. Two logs give wide intervals, since
    two values say little about their scatter; three or more are better.

    Parameters
    ----------
    logs : sequence
        What `read_log` returns, or (time, position, force) as in `identify`. The runs of a log count as logs.
    axes, stiffness, coulomb, offset, drag, stiction, radius, cutoff, method, iterations, force_delay
        As in `identify`, for all logs; the axes' names are by default those of the first log.

    Returns
    -------
    Identification
        Of the robot; `logs` has what each log gives alone.

    Raises
    ------
    telespring.InvalidInput
        As `identify`, for the first log that cannot be used; or if the logs have different numbers of axes.

    Examples
    --------
    >>> import numpy as np
    >>> from telespring.identification import identify_logs, paper_excitation
    >>> movement = paper_excitation()
    >>> t = np.arange(10000) / 1000.0
    >>> def record(mass, seed):
    ...     force = mass * movement.acceleration(t) + 7.7 * movement.velocity(t)
    ...     return t, movement.position(t), force + np.random.default_rng(seed).normal(0.0, 0.05, t.size)
    >>> robot = identify_logs([record(0.80, 1), record(0.83, 2), record(0.81, 3)])
    >>> low, high = robot.axes[0].mass.interval
    >>> low < 0.80 and high > 0.83, robot.log_count
    (True, 3)
    """
    options = _fit_options(
        {"stiffness": stiffness, "coulomb": coulomb, "offset": offset, "drag": drag, "stiction": stiction},
        radius,
        method,
        iterations,
        force_delay,
    )
    if not logs:
        raise InvalidInput("logs", "none", "at least one log is required", "Name a log.")
    recordings = [recording for log in logs for recording in _recordings(log)]
    names = axes if axes is not None else getattr(logs[0], "axes", None)
    runs = [_Run(*recording, names, cutoff) for recording in recordings]
    if len({len(run.names) for run in runs}) > 1:
        raise InvalidInput(
            "logs",
            " and ".join(str(len(run.names)) for run in runs) + " axes",
            "logs of one robot have the same axes",
            "Identify each robot by itself.",
        )
    if len(runs) == 1:
        return runs[0].identify(options)
    fits = [run.fit(options) for run in runs]
    terms = _union_of_terms(fits)
    return combine_logs([run.identify(options, terms) for run in runs])


def _recordings(
    log: Log | tuple[ArrayLike, ArrayLike, ArrayLike],
) -> list[tuple[ArrayLike, ArrayLike, ArrayLike]]:
    """Return time, position and force of every run in a log."""
    if isinstance(log, tuple):
        return [log]
    runs = [log.run == number for number in np.unique(log.run)]
    return [(log.time[run], log.position[run], log.force[run]) for run in runs]


def _union_of_terms(fits: Sequence[LogFit]) -> tuple[AxisTerms, ...]:
    """Return, per axis, the terms that any of the logs needs."""
    terms = []
    for i in range(len(fits[0].terms)):
        each = [fit.terms[i] for fit in fits]
        names = tuple(dict.fromkeys(name for axis in each for name in axis.names))
        stiction = next((axis for axis in each if "stiction" in axis.names), each[0])
        terms.append(replace(each[0], names=names, stiction_index=stiction.stiction_index))
    return tuple(terms)


class _Run:
    """One log on its way to an identification: checked, without glitches, its cut-off chosen."""

    def __init__(
        self,
        time: ArrayLike,
        position: ArrayLike,
        force: ArrayLike,
        axes: Sequence[str] | None,
        cutoff: float | None,
    ) -> None:
        positions, forces = _log_signal_rows("position", position), _log_signal_rows("force", force)
        times = as_numbers("time", time)
        self.warnings: list[Diagnostic] = list(check_log(times, positions, forces))
        stretches, resampling_warnings = even_stretches(times, positions, forces)
        self.names = _identified_axis_names(axes, len(positions))
        self.stretches, glitch_warnings = without_glitches(stretches, self.names)
        self.warnings += [*resampling_warnings, *glitch_warnings]
        self.samples = sum(stretch.time.size for stretch in self.stretches)
        longest = self.longest
        for name, row in zip(self.names, longest.position, strict=True):
            _refuse_short_travel(name, row, longest.rate)
        self.cutoff = choose_cutoff(longest.position, longest.rate) if cutoff is None else float(cutoff)
        self.cutoff_rule = CUTOFF_RULE if cutoff is None else "as given"

    @property
    def longest(self) -> Stretch:
        """The stretch from which the cut-off is chosen."""
        return max(self.stretches, key=lambda stretch: stretch.time.size)

    def fit(self, options: FitOptions, terms: Sequence[AxisTerms] | None = None) -> LogFit:
        return fit_log(self.stretches, self.cutoff, self.names, options, terms)

    def identify(self, options: FitOptions, terms: Sequence[AxisTerms] | None = None) -> Identification:
        fit = self.fit(options, terms)
        inertias = estimate_inertias(fit)
        coupled = [
            tuple(other for other, inertia in each.items() if inertia.matters and not inertia.may_be_lag)
            for each in inertias
        ]
        if any(coupled) and options.method != "paper":
            # What the axes do to each other is neither mass nor lag of their own.
            together = [replace(axis, coupled=rows) for axis, rows in zip(fit.terms, coupled, strict=True)]
            fit = self.fit(options, together)
            # And once more with the lag that the coupled axes have.
            inertias = estimate_inertias(fit)
        found = identification_of(
            fit,
            self.names,
            inertias,
            cutoff_rule=self.cutoff_rule,
            rate=self.longest.rate,
            samples=self.samples,
        )
        doubts = diagnostics.check_fit(found, fit, self.stretches, self.names)
        return replace(found, diagnostics=(*self.warnings, *doubts))


def _fit_options(
    asked: dict[str, bool | None],
    radius: float | None,
    method: Method,
    iterations: int,
    force_delay: float | None,
) -> FitOptions:
    _refuse_unknown_method(method, iterations)
    if radius is not None and not 0.0 < as_number("radius", radius) < float("inf"):
        raise InvalidInput(
            "radius", f"{radius:g}", "a radius above 0 m is required", "Give the metres of travel per radian."
        )
    lag = None if force_delay is None else as_number("force_delay", force_delay)
    if lag is not None and not abs(lag) <= _LONGEST_DELAY:
        raise InvalidInput(
            "force_delay",
            f"{lag:g} s",
            f"a lag between -{_LONGEST_DELAY:g} and {_LONGEST_DELAY:g} s is required",
            "Give it in seconds: 0.001 is one millisecond. Omit it to have it estimated.",
        )
    if method == "paper":
        # The paper's model: mass and damping, and what was asked for.
        asked = {name: bool(choice) for name, choice in asked.items()}
        lag = lag or 0.0
    return FitOptions(ModelTerms(asked, radius), method, iterations, lag)


def _log_signal_rows(name: str, values: ArrayLike) -> FloatArray:
    """Transpose an array over (time,) or (time, axis) to one row per axis."""
    array = as_numbers(name, values)
    if array.ndim not in (1, 2) or array.size == 0:
        raise InvalidInput(
            name,
            f"an array of shape {array.shape}",
            "one value per sample, or one row per sample with one value per axis, is required",
            "Put time first: one row per sample.",
        )
    return np.ascontiguousarray(array.reshape(array.shape[0], -1).T)


def _identified_axis_names(axes: Sequence[str] | None, count: int) -> list[str]:
    """Return the given axis names, checked, or x, y, z."""
    if axes is None:
        return ["x", "y", "z"][:count] if count <= 3 else [f"axis {i + 1}" for i in range(count)]
    names = [str(name) for name in axes]
    if len(names) != count or len(set(names)) != count:
        raise InvalidInput(
            "axes",
            repr(names),
            f"{count} different names are required, one per axis",
            "Omit them for x, y.",
        )
    return names


def _refuse_unknown_method(method: str, iterations: int) -> None:
    if method not in METHODS:
        raise InvalidInput(
            "method",
            repr(method),
            'the methods are "robust", "ols" and "paper"',
            'Omit it for "robust".',
        )
    if not 1 <= iterations <= 10_000:
        raise InvalidInput("iterations", str(iterations), "1 to 10000 reweightings are allowed", "Use 1.")
    if iterations != 1 and method != "paper":
        raise InvalidInput(
            "iterations",
            str(iterations),
            f"only the paper's method has reweightings, but the method is {method!r}",
            'Omit it, or choose the method "paper".',
        )


def _refuse_short_travel(name: str, position: FloatArray, rate: float) -> None:
    travel = float(np.ptp(position))
    levels = np.unique(position).size
    if travel == 0.0 or levels < 50:
        raise InvalidInput(
            f"position ({name})",
            f"{levels} different values over {1e3 * travel:.3g} mm",
            "a position that moves through at least 50 steps of its sensor is required",
            "Move the robot further, or check that this is the right column and the sensor is connected.",
        )
    noise = noise_deviation(position, rate)
    if travel < max(_MINIMUM_TRAVEL, _TRAVEL_PER_NOISE * noise):
        raise InvalidInput(
            f"position ({name})",
            f"{1e3 * travel:.3g} mm of travel, {1e3 * noise:.2g} mm of noise",
            f"this axis moves too little: at least {1e3 * _MINIMUM_TRAVEL:g} mm and {_TRAVEL_PER_NOISE:g} "
            "times the noise are required",
            "Move it further, name only the axes that move, or check the unit (--position-scale).",
        )
