"""The wording of every warning about a log or an estimate, by code.

The checks compute codes and values; only this module words them. It belongs to this room because
`Identification.warnings`, `Identification.to_json` and robot files carry the sentences.
"""

from __future__ import annotations

import re
import string
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

from telespring._quantities import format_number, format_time

__all__ = ["UNITS", "Diagnostic", "diagnostic", "outside_intervals"]

#: The power of ten between an SI value and these units.
_SHIFTS = {"mm": 3, "%": 2}

UNITS = {
    "mass": "kg",
    "damping": "N·s/m",
    "stiffness": "N/m",
    "coulomb": "N",
    "offset": "N",
    "drag": "N·s²/m²",
    "stiction": "N",
    "gravity_sine": "N",
    "gravity_cosine": "N",
}

_OMITTED = (
    "Axis {axis}: the log has %s, but --no-%s rules it out. Leave out --no-%s for a mass of {mass:.4g} "
    "kg (now "
    "{fitted_mass:.4g} kg) and a damping of {damping:.4g} N·s/m (now {fitted_damping:.4g} N·s/m)."
)


_MESSAGES = {
    # the log
    "suspect force column": (
        "The force column {column} looks like a voltage, a current or a command. If it is one, give the "
        "newtons per unit with --force-scale. Otherwise mass and damping are wrong by that factor. Scalars "
        "in the same file: {scalars}."
    ),
    "words among numbers": (
        'Fields of the column {column} that are no numbers: {count}, the first "{word}". They count as lost '
        "samples."
    ),
    "bridged gaps": (
        "Lost samples: {count} (gaps: {gaps}, the longest {longest:.3g s}). They were interpolated, and the "
        "estimates leave them out."
    ),
    "long gaps": (
        "Long gaps: {count}, the longest {longest:.3g s} after {place}. The estimates are from "
        "what lies between them (stretches: {pieces})."
    ),
    "samples between gaps": "Samples between two close gaps, left out: {count}.",
    "repeated samples": (
        "Repeated samples: {count}. A row with the time and the values of the row before was left out."
    ),
    "glitches": (
        "Glitches in the {column}, samples that leave the signal and come back, or repeat an old value: "
        "{count} ({share:.2g %}). The estimates leave them out. Check the sensor's cable and the logger."
    ),
    "same log": "{log} was given more than once. It counts once.",
    "copied log": "{log} has the same samples as {other}, to the last digit. They count once.",
    "repeated part": (
        "The samples from {place} on repeat those from {source} on, to the last digit ({count} in all). "
        "They count once."
    ),
    "uneven time stamps": (
        "Time stamps are uneven, with a jitter of {jitter:.2g %} of the sample period. The log was "
        "interpolated."
    ),
    "identical positions": "Two axes have identical positions. Is a column named twice?",
    "held position": (
        "The {column} repeats every value {repeats} times: it is updated every {period:.3g s} and is "
        "{age:.2g s} old on average, which biases the mass. Keep only the first of every {repeats} "
        "samples."
    ),
    "position jumps": (
        "The {column} jumps by {size:.3g mm} after {place}. Jumps in all: {count}. Did the sensor slip?"
    ),
    "saturated force": (
        "The {column} stays at its extreme of {force:.3g} N for {duration:.3g s} from {place} on. Was it "
        "saturated?"
    ),
    "constant force": (
        "The {column} stays at {force:.3g} N for {duration:.3g s} from {place} on. Was the sensor stuck?"
    ),
    # the model
    "omitted stiffness": _OMITTED % ("a spring of {value:.3g} N/m to the ground", "stiffness", "stiffness"),
    "omitted coulomb": _OMITTED % ("friction of {value:.3g} N", "coulomb", "coulomb"),
    "omitted offset": _OMITTED % ("an offset of {value:.3g} N", "offset", "offset"),
    "omitted drag": _OMITTED % ("a force of {value:.3g} N·s²/m² times v|v|", "drag", "drag"),
    "omitted stiction": _OMITTED % ("stiction of {value:.3g} N", "stiction", "stiction"),
    "omitted effect": (
        "Axis {axis}: the force also depends on {effect}, and the model has no such term. With it the "
        "mass would "
        "be {mass:.4g} kg (now {fitted_mass:.4g} kg) and the damping {damping:.4g} N·s/m (now "
        "{fitted_damping:.4g} N·s/m). The intervals do not include this."
    ),
    "spring": (
        "Axis {axis}: a spring of {stiffness:.3g} N/m ({low:.3g} to {high:.3g} N/m) pulls the robot to "
        "a place. "
        "Mass and damping allow for it. Verdicts from the robot file include the spring, and rehearse leaves "
        "it out."
    ),
    "unconfirmed spring": (
        "Axis {axis}: the logs together do not show a spring ({low:.3g} to {high:.3g} N/m). The robot file "
        "has none."
    ),
    "negative spring": (
        "Axis {axis}: a force pushes the robot away from the middle, like a spring of {stiffness:.3g} N/m "
        "({low:.3g} to {high:.3g} N/m). Mass and damping allow for it, but no verdict can: remove its "
        "cause, for "
        "example a counterweight or a slope."
    ),
    "stiction": (
        "Axis {axis}: friction is larger near rest, by {value:.2g} N within {velocity:.2g} m/s. Mass "
        "and damping "
        "allow for it. Studies and verdicts have no such friction."
    ),
    "drag": (
        "Axis {axis}: the log has a force of {value:.3g} N·s²/m² times v|v|. The damping is that of slow "
        "movements. Studies and verdicts leave the rest out."
    ),
    "gravity": (
        "Axis {axis}: gravity acts on this axis, {value:.3g} N times the sine or cosine of its angle. "
        "Mass and "
        "damping allow for it. Studies and verdicts leave it out: where it pulls back it is like a spring."
    ),
    "late force": (
        "The force lags the position by {lag:.2g s} ({low:.2g s} to {high:.2g s}). The "
        "estimates allow for it."
    ),
    "late position": (
        "The position lags the force by {lag:.2g s} ({low:.2g s} to {high:.2g s}). The "
        "estimates allow for it."
    ),
    "force lag": (
        "Axis {axis}: the force seems to be late by {lag:.2g s}, unlike the given --force-delay. Leave out "
        "--force-delay for a mass of {mass:.4g} kg (now {fitted_mass:.4g} kg) and a damping of {damping:.4g} "
        "N·s/m (now {fitted_damping:.4g} N·s/m)."
    ),
    "untested spring": (
        "Axis {axis}: this movement at one frequency cannot show whether a spring pulls the robot to a "
        "place, "
        "which you ruled out: each N/m of it would take {mass_per_stiffness:.2g} kg off the mass."
    ),
    "unknown lag": (
        "Axis {axis}: this movement cannot show whether the force is late, and each ms shifts the mass by "
        "{mass_per_ms:.2g} kg. If force and position are sampled together, say so with --force-delay 0. "
        "Otherwise excite several frequencies."
    ),
    "lags differ": (
        "The axes disagree about the lag of the force ({names}: {lags}), and the estimates use each "
        "axis' own. "
        "Sensors that are sampled together have one lag: look for another force on these axes."
    ),
    "lag or coupling": (
        "Axis {axis}: in this movement a lag of the force ({lag:.2g s}) and inertia between the axes "
        "look the "
        "same. Excite the axes with different movements to see which it is."
    ),
    "logs disagree": (
        "Axis {axis}: the logs disagree about the {parameter} ({values} {unit}) by more than their own "
        "errors. "
        "The interval includes this scatter. Did the sensor, its zero or the robot change between them?"
    ),
    "coupled axes": (
        "The axes are not independent: the force on {axis} includes {inertia:.3g} kg ({low:.3g} to "
        "{high:.3g} kg) times the acceleration on {other}. Verdicts for single axes do not hold for this "
        "robot as it was measured."
    ),
    "similar movements": (
        "This log cannot show whether the axes are independent: they moved too much alike. Excite them with "
        "different movements, for example the same movement a quarter of a period later."
    ),
    # the estimates
    "negative estimates": (
        "Axis {axis}: negative {parameters}. Force and position must be positive in the same direction; "
        "--force-scale -1 reverses the force."
    ),
    "negative friction": (
        "Axis {axis}: Coulomb friction is negative, {coulomb:.3g} N ({low:.3g} to {high:.3g} N): a "
        "force in the "
        "direction of the movement. The robot file has 0. Does a controller compensate for friction?"
    ),
    "mass close to zero": (
        "Axis {axis}: the mass cannot be distinguished from 0. Excite the robot with more acceleration or "
        "record longer."
    ),
    "damping close to zero": (
        "Axis {axis}: the damping cannot be distinguished from 0. Excite the robot at higher velocity or "
        "record longer."
    ),
    "unexplained force": (
        "Axis {axis}: the model explains only {r_squared:.0f %} of the force. Do position and force belong "
        "to the same axis?"
    ),
    "many outliers": (
        "Axis {axis}: {share:.0f %} of the samples were rejected as outliers. Look at the residuals "
        "(--figure)."
    ),
    "no convergence": "Axis {axis}: the robust fit did not converge. Compare it with --method ols.",
    "noise bias": (
        "Axis {axis}: at a cut-off of {cutoff:.3g} Hz position noise makes the {parameter} about {bias:.2g} "
        "{unit} too small, which is {half_widths:.1g} times the half-width of its interval. Set --cutoff to "
        "{largest_cutoff:.3g} Hz or less."
    ),
    "cut-off dependence": (
        "Axis {axis}: the {parameter} depends on the cut-off: {value:.3g} {unit} at {cutoff:.3g} Hz, but "
        "{other_value:.3g} {unit} at {other_cutoff:.3g} Hz. The difference is larger than both intervals. "
        "Check whether the position jumps, and the residuals (--figure)."
    ),
    "implausible motion": (
        "Axis {axis} reaches {velocity:.3g} m/s and {acceleration:.3g} m/s², more than a robot held by a "
        "person. Is the time in s (--time-scale 60 for minutes) and the position in m (--position-scale "
        "0.001 for mm, 0.01 for cm)?"
    ),
    "implausibly light": (
        "Axis {axis}: {mass:.2g} kg is lighter than any robot held by a person. Are time, position and "
        "force in s, m and N (--time-scale, --position-scale, --force-scale)?"
    ),
    "implausibly heavy": (
        "Axis {axis}: {mass:.3g} kg is heavier than any robot held by a person. Are time, position and "
        "force in s, m and N (--force-scale 0.001 for mN)?"
    ),
}


@dataclass(frozen=True)
class Diagnostic:
    """A reason to doubt a log or an estimate.

    Attributes
    ----------
    code
        What is doubtful, such as "noise bias".
    values
        Its numbers in SI units, and the names of axis, parameter or column.
    message
        The sentence that a user reads.
    """

    code: str
    values: Mapping[str, Any]
    message: str


def diagnostic(code: str, **values: Any) -> Diagnostic:
    """Word a warning of an identification: its code selects the sentence, and its values fill it."""
    return Diagnostic(code, values, _QuantityFormatter().format(_MESSAGES[code], **values))


def outside_intervals(method: str, logs: int) -> str:
    """Say what the intervals from a number of logs do not include."""
    if method == "paper":
        return "These intervals are not valid."
    if logs > 1:
        return (
            f"The intervals are from {logs} logs and include their scatter. A wrong "
            f"gain of "
            "the force or position sensor and what no log excites are outside them."
        )
    return (
        "The intervals are from one log. What changes from log to log, a wrong gain of the force or position "
        "sensor and what the model leaves out are outside them: identify several logs together."
    )


class _QuantityFormatter(string.Formatter):
    """Writes `{size:.3g mm}` with three digits in mm, and joins texts with "and".

    A time, `{lag:.3g s}`, is in ms below 1 s.
    """

    def format_field(self, value: Any, format_spec: str) -> str:
        if isinstance(value, tuple):
            return " and ".join(value)
        spec, _, unit = format_spec.partition(" ")
        digits = re.fullmatch(r"\.(\d)g", spec)
        if digits is None:
            # Adding 0 turns what rounds to −0 into 0.
            shown = format(round(10.0 ** _SHIFTS[unit] * value) + 0 if unit else value, spec)
        elif unit == "s":
            return format_time(value, int(digits[1]))
        else:
            shown = format_number(value, int(digits[1]), shift=_SHIFTS.get(unit, 0))
        return f"{shown} {unit}" if unit else shown
