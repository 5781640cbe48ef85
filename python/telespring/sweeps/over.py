"""What a sweep goes over: keys of the study, each with its values."""

from __future__ import annotations

import json
import math
import re
import tomllib
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from telespring._errors import InvalidInput

__all__ = ["Over", "as_number", "read_over", "read_overs"]

_KEY = re.compile(r"[a-z_]+\d?\.[a-z_]+")
_RANGE = re.compile(r"(log:)?([^:,\s]+):([^:,\s]+):(\d+)")
#: Numbers with something else between them than a comma.
_NUMBERS = re.compile(r"[-+.\d][-+.\deE]*(\s*[:;\s]\s*[-+.\d][-+.\deE]*)+")
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

    @property
    def sets(self) -> tuple[tuple[str, str], ...]:
        """Which section and key of a study it gives a value to: of short names, several."""
        section, _, key = self.key.partition(".")
        return _BOTH.get(self.key, ((section, key),))

    def changes(self, place: int) -> dict[str, dict[str, Any]]:
        """Return what this value changes in a study, as `Study.replace` takes it."""
        changed: dict[str, dict[str, Any]] = {}
        for where in self.sets:
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
        found = [read_over(text) for text in ([over] if isinstance(over, str) else over)]
    for place, each in enumerate(found):
        for before in found[:place]:
            _refuse_both(before, each)
    return tuple(found)


def _refuse_both(one: Over, other: Over) -> None:
    """Refuse two keys of which the second would overwrite the first."""
    shared = [".".join(where) for where in one.sets if where in other.sets]
    if not shared:
        return
    if one.key == other.key:
        raise InvalidInput("over", one.key, "a key is swept once", "Give all its values together.")
    raise InvalidInput(
        "over",
        f"{one.key}, {other.key}",
        f"a key is swept once, and both of these set {shared[0]}",
        "Leave one of them out: stiffness and delay stand for those of the coupling, or network, and of the "
        "protocol.",
    )


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
    for each in written.split(","):
        _refuse_what_is_no_word(text, key, each.strip())
    return _from_values(key, [_scalar(each.strip()) for each in written.split(",")])


def _refuse_what_is_no_word(text: str, key: str, written: str) -> None:
    """Refuse what is neither a number nor a word: a range, list or table that was written otherwise."""
    if not written:
        raise InvalidInput(
            "over",
            text,
            "a value is required before and after each comma",
            "Leave out the comma that has none.",
        )
    if any(sign in written for sign in "{}[]="):
        raise InvalidInput(
            "over",
            text,
            "tables, and what stands beside them, are written as one list in TOML",
            f'Write, for example, {key}=["spring", {{kind = "guard", share = 0.5}}].'
            if key == "session.strategy"
            else f"Write {key}=[…, …], words in quotation marks.",
        )
    if _NUMBERS.fullmatch(written):
        raise InvalidInput(
            "over", text, "a list of numbers with commas, or a range from:to:how many, is required", _REMEDY
        )


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
    if written in ("true", "false", "True", "False"):
        return written.lower() == "true"
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
    if key.count(".") > 1:
        section, name, *inner = key.split(".")
        raise InvalidInput(
            "over",
            key,
            "a key is a section and a name; what is inside of a table is swept by whole tables",
            f"Write {section}.{name}=[{{…, {inner[0]} = …}}, {{…}}] with all that each table has.",
        )
    if key not in _BOTH and _KEY.fullmatch(key) is None:
        raise InvalidInput(
            "over",
            key,
            "a key of the study with its section, such as network.loss, or stiffness, or delay",
            _REMEDY,
        )
    listed = _listed(key, values)
    try:
        texts = tuple(json.dumps(_plain(value), sort_keys=True, allow_nan=False) for value in listed)
    except (TypeError, ValueError):
        raise InvalidInput(
            "over", key, "values are finite numbers, words, lists and tables", _REMEDY
        ) from None
    seen: set[float | str] = set()
    for text in texts:
        if as_number(text) in seen:
            raise InvalidInput("over", f"{key}={text}", "a value is given once", "Leave the second one out.")
        seen.add(as_number(text))
    return Over(key, texts)


def as_number(text: str) -> float | str:
    """Return the number that the text of a value means, or the text: 30 and 30.0 are one value.

    Examples
    --------
    >>> as_number("30") == as_number("30.0")
    True
    """
    try:
        return float(text)
    except ValueError:
        return text


def _listed(key: str, values: Any) -> list[Any]:
    """Return the values of a key as a list; a word or a table is one value, not several."""
    is_one = isinstance(values, str | bytes | Mapping) or not isinstance(values, Iterable)
    if is_one or (isinstance(values, np.ndarray) and not values.ndim):
        raise InvalidInput(
            "over", f"{key}: {values!r}", "a list of values is required", f"Write [{values!r}]."
        )
    listed = values.tolist() if isinstance(values, np.ndarray) else list(values)
    if not listed:
        raise InvalidInput("over", key, "at least one value is required", _REMEDY)
    return listed


def _plain(value: Any) -> Any:
    """Return NumPy's numbers as Python's, and whole numbers as they are."""
    return value.item() if isinstance(value, np.generic) else value
