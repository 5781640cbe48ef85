"""What a sweep goes over: keys of the study, each with its values."""

from __future__ import annotations

import json
import math
import re
import tomllib
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from telespring._errors import InvalidInput

__all__ = ["Over", "read_over", "read_overs"]

_KEY = re.compile(r"[a-z_]+\d?\.[a-z_]+")
_RANGE = re.compile(r"(log:)?([^:,\s]+):([^:,\s]+):(\d+)")
_MOST = 1_000_000
_REMEDY = (
    "Write, for example, coupling.stiffness=20,40,80 or network.delay=0:0.2:11 (from, to, how many) or "
    "robot1.damping=log:1:20:9."
)
#: Short names of what both the verdicts and the trials use.
_BOTH = {
    "stiffness": (("coupling", "stiffness"), ("protocol", "stiffness")),
    "delay": (("network", "delay"), ("protocol", "delay")),
}
#: Lists in the protocol, of which a sweep gives one value at a time.
_LISTS = {("protocol", "stiffness"), ("protocol", "delay")}


@dataclass(frozen=True)
class Over:
    """One key with its values.

    Attributes
    ----------
    key
        A key of the study, such as ``network.loss``; or ``stiffness`` or ``delay``, which stand for the
        coupling's or network's and for the protocol's.
    values
        Its values, as JSON texts, so that equal sweeps are equal.
    """

    key: str
    values: tuple[str, ...]

    def value(self, place: int) -> Any:
        """Return one value."""
        return json.loads(self.values[place])

    def changes(self, place: int) -> dict[str, dict[str, Any]]:
        """Return what this value changes in a study, as `Study.replace` takes it."""
        section, _, key = self.key.partition(".")
        changed: dict[str, dict[str, Any]] = {}
        for where in _BOTH.get(self.key, ((section, key),)):
            value = self.value(place)
            is_single = where in _LISTS and not isinstance(value, list)
            changed.setdefault(where[0], {})[where[1]] = [value] if is_single else value
        return changed

    def coordinate(self) -> Any:
        """Return the values as a coordinate: numbers where all are numbers, otherwise words."""
        values = [self.value(place) for place in range(len(self.values))]
        if all(isinstance(value, int | float) and not isinstance(value, bool) for value in values):
            return np.array(values, dtype=np.float64)
        return np.array([_word(value) for value in values], dtype=object)

    def thinned(self) -> Over:
        """Return the key with its first, middle and last value only."""
        places = sorted({0, len(self.values) // 2, len(self.values) - 1})
        return Over(self.key, tuple(self.values[place] for place in places))


def _word(value: Any) -> str:
    return value if isinstance(value, str) else json.dumps(value, sort_keys=True, ensure_ascii=False)


def read_overs(over: Mapping[str, Any] | Sequence[str] | None) -> tuple[Over, ...]:
    """Read all keys of a sweep: a mapping from key to values, or texts as on the command line."""
    if over is None:
        return ()
    if isinstance(over, Mapping):
        found = [_from_values(key, values) for key, values in over.items()]
    else:
        found = [read_over(text) for text in over]
    keys = [each.key for each in found]
    doubled = next((key for key in keys if keys.count(key) > 1), None)
    if doubled is not None:
        raise InvalidInput("over", doubled, "a key is swept once", "Give all its values together.")
    return tuple(found)


def read_over(text: str) -> Over:
    """Read a key with its values as the command line has them.

    Examples
    --------
    >>> read_over("network.loss=0,0.1").values
    ('0', '0.1')
    >>> read_over("stiffness=log:10:1000:3").values
    ('10', '100', '1000')
    >>> read_over("session.strategy=spring,guard").values
    ('"spring"', '"guard"')
    """
    key, equals, written = (part.strip() for part in text.partition("="))
    if not equals or not written:
        raise InvalidInput("over", text, "a key of the study, =, and its values", _REMEDY)
    found = _RANGE.fullmatch(written)
    if found is not None:
        return _from_values(key, _range(text, found))
    if written.startswith(("[", "{")):
        listed = _toml(text, written)
        return _from_values(key, listed if isinstance(listed, list) else [listed])
    return _from_values(key, [_scalar(each.strip()) for each in written.split(",")])


def _range(text: str, found: re.Match[str]) -> list[float] | list[int]:
    try:
        low, high, count = float(found[2]), float(found[3]), int(found[4])
    except ValueError:
        raise InvalidInput("over", text, "a range is from:to:how many, in numbers", _REMEDY) from None
    is_log = found[1] is not None
    if not (1 <= count <= _MOST and math.isfinite(low) and math.isfinite(high)):
        raise InvalidInput("over", text, f"a range has 1 to {_MOST} finite values", _REMEDY)
    if is_log and not (low > 0.0 and high > 0.0):
        raise InvalidInput("over", text, "a logarithmic range has ends above 0", _REMEDY)
    spaced = np.geomspace(low, high, count) if is_log else np.linspace(low, high, count)
    # Twelve digits: what was meant, whatever the last bit of a library's logarithm.
    values = [float(f"{value:.12g}") for value in spaced]
    are_whole = "." not in found[2] + found[3] and all(value.is_integer() for value in values)
    return [int(value) for value in values] if are_whole else values


def _scalar(written: str) -> Any:
    if written in ("true", "false"):
        return written == "true"
    try:
        return int(written)
    except ValueError:
        pass
    try:
        return float(written)
    except ValueError:
        return written.strip("\"'")


def _toml(text: str, written: str) -> Any:
    try:
        return tomllib.loads(f"values = {written}")["values"]
    except tomllib.TOMLDecodeError as error:
        raise InvalidInput("over", text, f"a list or table must be TOML ({error})", _REMEDY) from None


def _from_values(key: str, values: Any) -> Over:
    if key not in _BOTH and _KEY.fullmatch(key) is None:
        raise InvalidInput(
            "over",
            key,
            "a key of the study with its section, such as network.loss, or stiffness, or delay",
            _REMEDY,
        )
    listed = values.tolist() if isinstance(values, np.ndarray) else list(values)
    if not listed:
        raise InvalidInput("over", key, "at least one value is required", _REMEDY)
    try:
        texts = tuple(json.dumps(_plain(value), sort_keys=True, allow_nan=False) for value in listed)
    except (TypeError, ValueError):
        raise InvalidInput(
            "over", key, "values are finite numbers, words, lists and tables", _REMEDY
        ) from None
    return Over(key, texts)


def _plain(value: Any) -> Any:
    """Return NumPy's numbers as Python's, and whole numbers as they are."""
    return value.item() if isinstance(value, np.generic) else value
