"""Time stamps as loggers write them: seconds, counts since an epoch, dates, times of the day.

Long stamps are subtracted from one another as whole numbers, before they become seconds: the time since 1970
in a double is exact to 0.2 µs only, and in six digits to half an hour.
"""

from __future__ import annotations

import re
from collections.abc import Iterator
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from telespring._errors import InvalidInput
from telespring._tables import numbers_from_texts
from telespring._types import FloatArray

__all__ = ["TimeStamps", "read_time_stamps"]

#: Seconds since 1970 of stamps from 1985 to 2100.
_EPOCH = (0.5e9, 4.1e9)
_EPOCH_UNITS = {"s": 1.0, "ms": 1e-3, "µs": 1e-6, "ns": 1e-9}
#: A log has at least so many samples per second; slower stamps are in another unit.
_LONGEST_STEP = 0.06
#: At least this share of stamps must have the format; the others are lost samples.
_READABLE = 0.9
#: Units of dates per second.
_PER_SECOND = {"s": 1, "ms": 10**3, "us": 10**6, "ns": 10**9}
#: A time of the day starts again after a day, minutes and seconds after an hour, s.
_DAY, _HOUR = 86_400.0, 3_600.0
_LARGEST_COUNT = 2**63 - 1
_DECIMAL = re.compile(r"[+-]?(\d+\.?\d*|\.\d+)")
_CLOCK = re.compile(r"\d{1,2}:\d{2}(:\d{2}(\.\d+)?|\.\d+)")
_DATES = (
    *(f"%d.%m.%Y{gap}%H:%M:%S{fraction}" for gap in (" ", "T") for fraction in (".%f", "")),
    *(
        f"{date} %H:%M:%S{fraction}"
        for date in ("%m/%d/%Y", "%d/%m/%Y", "%d-%b-%Y")
        for fraction in (".%f", "")
    ),
    *(f"{date} %I:%M:%S{fraction} %p" for date in ("%m/%d/%Y", "%d/%m/%Y") for fraction in (".%f", "")),
)


@dataclass(frozen=True, eq=False)
class TimeStamps:
    """Times of the samples.

    Attributes
    ----------
    seconds
        s; counted from the first sample if the stamps are dates, times of the day or counts since 1970. NaN
        where a sample has no stamp.
    form
        "s", "epoch in ms" (or s, µs, ns), "date" or "time of the day".
    first
        The first stamp as an ISO date, if the stamps are dates or counts since 1970.
    """

    seconds: FloatArray
    form: str = "s"
    first: str | None = None


def read_time_stamps(values: Any, scale: float, decimal: str = ".") -> TimeStamps:
    """Read a time column: an array or pandas series of numbers, dates, durations or texts.

    `scale` is in seconds per unit of numbers; with 1, counts since 1970 in s, ms, µs or ns are known by their
    size. `decimal` is the decimal mark of texts. InvalidInput where texts are no time, or a scale is given
    for dates.
    """
    import pandas as pd

    column = pd.Series(values)
    kind = column.dtype.kind
    if kind in "Mm":
        return _from_dates(column, scale)
    if kind in "biuf":
        whole = kind in "iu" and bool(column.notna().all())
        numbers = column.to_numpy(dtype=kind + "8" if whole else float, na_value=np.nan)
        return _from_numbers(numbers, scale)
    texts = column.astype("str").str.strip().where(column.notna())
    exact = _exact_decimals(texts.str.replace(",", ".", regex=False) if decimal == "," else texts)
    if exact is not None:
        return _from_numbers(exact[0], scale * exact[1])
    numbers = numbers_from_texts(texts, decimal)
    if np.isfinite(numbers).sum() >= _READABLE * max(1, int(texts.notna().sum())):
        return _from_numbers(numbers, scale)
    return _from_dates(*_dates_of_texts(texts, scale))


def _from_numbers(values: NDArray[Any], scale: float) -> TimeStamps:
    """Scale numbers to seconds; counts since 1970 are counted from the first sample."""
    seconds = values.astype(float) * scale
    known = np.flatnonzero(np.isfinite(seconds))
    if not known.size:
        return TimeStamps(seconds)
    first = values[known[0]]
    step = float(np.median(np.abs(np.diff(seconds[known])))) if known.size > 1 else 0.0
    for name, unit in _EPOCH_UNITS.items():
        # Texts come as whole numbers of a power of ten of their unit; a scale by the user is the unit.
        is_epoch = _EPOCH[0] <= abs(seconds[known[0]]) * unit <= _EPOCH[1] and step * unit <= _LONGEST_STEP
        if is_epoch and (unit == 1.0 or _is_power_of_ten(scale)):
            since = (values - first).astype(float) * (scale * unit)
            date = np.datetime64(round(float(seconds[known[0]]) * unit * 1e3), "ms")
            return TimeStamps(since, f"epoch in {name}", str(date))
    if values.dtype.kind in "iu":
        return TimeStamps(float(first) * scale + (values - first).astype(float) * scale)
    return TimeStamps(seconds)


def _is_power_of_ten(scale: float) -> bool:
    return scale > 0.0 and abs(np.log10(scale) - round(float(np.log10(scale)))) < 1e-9


def _exact_decimals(texts: Any) -> tuple[NDArray[np.int_], float] | None:
    """Return decimals of many digits as whole numbers and their unit; None if they are not such."""
    import pandas as pd

    if texts.isna().any() or not texts.str.fullmatch(_DECIMAL).all():
        return None
    parts = texts.str.partition(".")
    whole, fraction = parts[0], parts[2]
    largest = 1 + int(abs(pd.to_numeric(whole.where(whole.str.strip("+-") != "", "0"))).max())
    if largest > _LARGEST_COUNT:
        return None
    digits = int(fraction.str.len().max())
    while digits > 0 and largest * 10**digits > _LARGEST_COUNT:
        digits -= 1
    count = (whole + fraction.str.ljust(digits, "0").str.slice(0, digits)).astype("int64")
    return count.to_numpy(), 10.0**-digits


def _from_dates(column: Any, scale: float, wrap: float = _DAY) -> TimeStamps:
    """Count dates or times of the day from the first; times of the day start again after `wrap`, s."""
    if scale != 1.0:
        raise InvalidInput(
            "time_scale",
            f"{scale:g}",
            "only numbers have a scale, and this time column has dates or times of the day",
            "Omit --time-scale.",
        )
    is_date = column.dtype.kind == "M"
    if is_date and getattr(column.dtype, "tz", None) is not None:
        column = column.dt.tz_convert("UTC").dt.tz_localize(None)
    resolution = column.to_numpy()
    missing = np.isnat(resolution)
    counts = resolution.astype("int64")
    per_second = _PER_SECOND[np.datetime_data(resolution.dtype)[0]]
    seconds = np.full(counts.size, np.nan)
    if not missing.all():
        first = int(np.flatnonzero(~missing)[0])
        since = (counts - counts[first])[~missing]
        if not is_date:
            again = round(wrap * per_second)
            since = since + again * np.cumsum(np.diff(since, prepend=since[0]) < -again // 2)
        seconds[~missing] = since / per_second
    if not is_date:
        return TimeStamps(seconds, "time of the day")
    return TimeStamps(seconds, "date", None if missing.all() else str(resolution[~missing][0]))


def _dates_of_texts(texts: Any, scale: float) -> tuple[Any, float, float]:
    """Parse texts by the format that nearly all of them have, as arguments of `_from_dates`."""
    required = _READABLE * max(1, int(texts.notna().sum()))
    for parsed, wrap in _parsed_dates(texts.str.replace(r"(?<=:\d\d),(?=\d)", ".", regex=True)):
        if parsed.notna().sum() >= required:
            return parsed, scale, wrap
    shown = next(iter(texts.dropna()), "empty")
    raise InvalidInput(
        "time",
        shown,
        "numbers, dates as in ISO 8601 (2024-05-01T12:00:00.001) or times of the day (12:00:00.001) are "
        "required",
        "Name another column with --time, or give the sample rate with --rate.",
    )


def _parsed_dates(texts: Any) -> Iterator[tuple[Any, float]]:
    """Parse texts in one format after the other, each with the time after which stamps start again, s."""
    import pandas as pd

    yield pd.to_datetime(texts, format="ISO8601", utc=True, errors="coerce"), _DAY
    clock = texts.where(texts.str.fullmatch(_CLOCK, na=False))
    if clock.notna().any():
        # Excel writes minutes and seconds: 12:00.001
        has_hours = clock.str.count(":") != 1
        full = clock.where(has_hours, "00:" + clock)
        yield pd.to_timedelta(full, errors="coerce"), _DAY if has_hours.all() else _HOUR
    for form in _DATES:
        yield pd.to_datetime(texts, format=form, errors="coerce"), _DAY
