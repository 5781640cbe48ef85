"""Identification of a robot from logs: mass, damping, friction and springs of each axis."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from typing import TYPE_CHECKING, Unpack

from numpy.typing import ArrayLike

from telespring.identification.assembly import combine_logs
from telespring.identification.log_fit import LogFit
from telespring.identification.preparation import PreparedLog
from telespring.identification.recordings import (
    Recording,
    recording_of_arrays,
    recordings_of_logs,
    without_copies,
)
from telespring.identification.results import Identification
from telespring.identification.settings import Settings, fit_options, with_settings
from telespring.identification.terms import AxisTerms

if TYPE_CHECKING:
    from telespring.identification.log_reading import Log

__all__ = ["identify", "identify_logs"]


@with_settings
def identify(
    time: ArrayLike, position: ArrayLike, force: ArrayLike, **settings: Unpack[Settings]
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
    return _identify([recording_of_arrays(time, position, force, settings.get("axes"))], settings)


@with_settings
def identify_logs(
    logs: Sequence[Log | tuple[ArrayLike, ArrayLike, ArrayLike]], **settings: Unpack[Settings]
) -> Identification:
    """Estimate one robot from several logs; the scatter between them enters the intervals.

    Every log is fitted by itself with the same terms: those that any of them needs. The estimates are then
    combined as random effects, with the interval of Hartung and Knapp. Two logs give wide intervals, since
    two values say little about their scatter; three or more are better. A log that is given twice, or a part
    that repeats another to the last digit, counts once, with a warning.

    Parameters
    ----------
    logs : sequence
        What `read_log` returns, or (time, position, force) as in `identify`. The runs of a log count as logs.
    **settings
        The options of `identify`, for all logs; the axes' names are by default those of the first log.

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
    return _identify(recordings_of_logs(logs, settings.get("axes")), settings)


def _identify(recordings: Sequence[Recording], settings: Settings) -> Identification:
    options = fit_options(settings)
    kept, copies = without_copies(recordings)
    runs = [PreparedLog(each, settings.get("cutoff")) for each in kept]
    if len(runs) == 1:
        found = runs[0].identify(options)
    else:
        terms = _union_of_terms([run.fit(options) for run in runs])
        found = combine_logs([run.identify(options, terms) for run in runs], [run.name for run in runs])
    return replace(found, diagnostics=(*copies, *found.diagnostics))


def _union_of_terms(fits: Sequence[LogFit]) -> tuple[AxisTerms, ...]:
    """Return, per axis, the terms that any of the logs needs."""
    terms = []
    for i in range(len(fits[0].terms)):
        each = [fit.terms[i] for fit in fits]
        names = tuple(dict.fromkeys(name for axis in each for name in axis.names))
        stiction = next((axis for axis in each if "stiction" in axis.names), each[0])
        terms.append(replace(each[0], names=names, stiction_index=stiction.stiction_index))
    return tuple(terms)
