"""What a replay shows: each side as recorded, and under the replayed settings."""

from __future__ import annotations

from dataclasses import asdict, dataclass
from typing import TYPE_CHECKING, Any, Literal

import numpy as np
from numpy.typing import NDArray

from telespring._core import ReplayedSite, Study
from telespring._json import json_ready
from telespring._types import FloatArray
from telespring.replays.sites import SiteRecording

if TYPE_CHECKING:
    import xarray as xr

__all__ = ["Replay", "SideNumbers", "SideReplay"]


@dataclass(frozen=True)
class SideNumbers:
    """One side in numbers. A number that nobody knows, for instance an age without a partner, is NaN.

    Attributes
    ----------
    force_rms, force_largest
        The force of the site on its handle while coupled, N.
    age_mean, age_quantile_99, age_largest
        The age of the partner's motion in use, s.
    held_share
        Share of the ticks at which an old motion was held because no later one had come.
    limited_share
        Share of the ticks with a partner at which the strategy changed the force of the spring.
    withheld_share
        Mean share of the spring's force that was withheld at those.
    engaged_share
        Share of the coupled ticks at which the watchdog let a force act.
    given_out
        Energy given out to the own handle, J: force times displacement.
    energy_sent, energy_received
        Energy sent to the partner and taken in from it, J.
    least_account
        The least energy in the account, J; NaN if the strategy keeps none.
    """

    force_rms: float
    force_largest: float
    age_mean: float
    age_quantile_99: float
    age_largest: float
    held_share: float
    limited_share: float
    withheld_share: float
    engaged_share: float
    given_out: float
    energy_sent: float
    energy_received: float
    least_account: float


def side_numbers(site: ReplayedSite, is_coupled: NDArray[np.bool_]) -> SideNumbers:
    """Reduce a replayed site to numbers, over the ticks at which its endpoint was asked."""
    sizes = np.hypot(*site.force[is_coupled].T)
    account = site.account[is_coupled]
    has_account = bool(np.isfinite(account).any())
    return SideNumbers(
        force_rms=float(np.sqrt(np.mean(sizes**2))) if sizes.size else float("nan"),
        force_largest=float(sizes.max()) if sizes.size else float("nan"),
        age_mean=site.age_mean,
        age_quantile_99=site.age_quantile_99,
        age_largest=site.age_high,
        held_share=site.held_share,
        limited_share=site.limited_share,
        withheld_share=site.withheld_share,
        engaged_share=float(np.mean(site.is_engaged[is_coupled])) if sizes.size else float("nan"),
        given_out=float(site.given_out[-1]) if len(site.given_out) else 0.0,
        energy_sent=site.energy_sent,
        energy_received=site.energy_received,
        least_account=float(np.nanmin(account)) if has_account else float("nan"),
    )


@dataclass(frozen=True, eq=False)
class SideReplay:
    """One side of a replayed session.

    Attributes
    ----------
    recording
        What was replayed.
    own
        The site under the session's own settings: as recorded, up to `differs_at`.
    replayed
        The site under the replayed settings.
    differs_at
        From this time on, s, the replay under the session's own settings gives another force than was
        recorded; None if it gives the recorded force at every tick, bit for bit.
    """

    recording: SiteRecording
    own: ReplayedSite
    replayed: ReplayedSite
    differs_at: float | None

    @property
    def side(self) -> int:
        """The robot of the study that the site moved, 1 or 2."""
        return self.recording.side

    @property
    def time(self) -> FloatArray:
        """Time of every tick since the first one of this side, s, (n,)."""
        return seconds_since_start(self.recording)

    @property
    def is_coupled(self) -> NDArray[np.bool_]:
        """Whether the endpoint was asked for a force at each tick, (n,)."""
        return np.asarray(self.recording.answered) > 0

    @property
    def recorded_numbers(self) -> SideNumbers:
        """The side as recorded, in numbers."""
        return side_numbers(self.own, self.is_coupled)

    @property
    def numbers(self) -> SideNumbers:
        """The side under the replayed settings, in numbers."""
        return side_numbers(self.replayed, self.is_coupled)

    @property
    def force_difference_rms(self) -> float:
        """RMS of the vector from the recorded force to the replayed one while coupled, N."""
        difference = (self.replayed.force - self.own.force)[self.is_coupled]
        return float(np.sqrt(np.mean(np.sum(difference**2, axis=1)))) if len(difference) else float("nan")

    def dataset(self) -> xr.Dataset:
        """Return the side's signals, recorded and replayed, over `time`."""
        import xarray as xr

        axes = ("x", "y")
        recording = self.recording
        signals: dict[str, tuple[Any, str, str]] = {
            "position": (recording.position, "m", "position of the handle as measured"),
            "recorded_force": (self.own.force, "N", "force on the handle as recorded"),
            "force": (self.replayed.force, "N", "force on the handle in the replay"),
        }
        per_tick: dict[str, tuple[Any, str, str]] = {
            "recorded_age": (self.own.age, "s", "age of the partner's motion in use as recorded"),
            "age": (self.replayed.age, "s", "age of the partner's motion in use in the replay"),
            "recorded_account": (self.own.account, "J", "energy in the account as recorded"),
            "account": (self.replayed.account, "J", "energy in the account in the replay"),
            "recorded_given_out": (self.own.given_out, "J", "energy given out to the handle as recorded"),
            "given_out": (self.replayed.given_out, "J", "energy given out to the handle in the replay"),
            "recorded_is_limited": (self.own.is_limited, "1", "whether the strategy changed the force"),
            "is_limited": (self.replayed.is_limited, "1", "whether the strategy changed it in the replay"),
        }
        variables: dict[str, Any] = {
            name: (("time", "axis"), values, {"units": unit, "long_name": text})
            for name, (values, unit, text) in signals.items()
        }
        variables |= {
            name: ("time", values, {"units": unit, "long_name": text})
            for name, (values, unit, text) in per_tick.items()
        }
        time = ("time", self.time, {"units": "s", "long_name": "time since the first tick of this side"})
        return xr.Dataset(variables, {"time": time, "axis": list(axes)}, {"side": self.side})

    def to_dict(self) -> dict[str, Any]:
        """Return the side in numbers, as JSON takes them."""
        found: dict[str, Any] = json_ready(
            {
                "side": self.side,
                "reproduced": self.differs_at is None,
                "differs_at": self.differs_at,
                "recorded": asdict(self.recorded_numbers),
                "replayed": asdict(self.numbers),
                "force_difference_rms": self.force_difference_rms,
                "renewed_packets": self.replayed.renewed,
                "packets": len(self.recording.arrival_time),
                "device_measured_force": self.recording.has_measured_force,
                "events": [
                    {"time": time, "event": word, "cause": reason or None}
                    for time, word, reason in self.events
                ],
            }
        )
        return found

    @property
    def events(self) -> list[tuple[float, str, str]]:
        """What happened in the replay: s since the first tick of this side, in a word, and why or ""."""
        if not len(self.recording.time):
            return []
        start = int(self.recording.time[0])
        return [(1e-9 * (time - start), word, reason) for time, word, reason in self.replayed.events]


@dataclass(frozen=True, eq=False)
class Replay:
    """A recorded session under the same or another control architecture. `replay` returns it.

    The motions and the network are the recorded ones, and nobody reacts to the replayed force: it is the
    force that this motion would have met, not the motion that this force would have led to.

    Attributes
    ----------
    recorded_study, study
        The study of the session, and the one that was replayed.
    sides
        What was replayed, one or both sides.
    partner
        "replayed" if both sides were: each gets the packets that the other makes in the replay. "as recorded"
        if there is one side only.
    """

    recorded_study: Study
    study: Study
    sides: tuple[SideReplay, ...]
    partner: Literal["replayed", "as recorded"]

    @property
    def is_own(self) -> bool:
        """Whether the session's own settings were replayed."""
        return self.study == self.recorded_study

    @property
    def is_reproduced(self) -> bool:
        """Whether the session's own settings give the recorded forces, bit for bit."""
        return all(side.differs_at is None for side in self.sides)

    @property
    def acted_force(self) -> Literal["as recorded", "as commanded"]:
        """Which force the energy account took as the one that acted.

        Under other settings it is the commanded one: what a device made of it, such as a lag, is not
        replayed.
        """
        return "as recorded" if self.is_own else "as commanded"

    def to_dict(self) -> dict[str, Any]:
        """Return the replay in numbers, as JSON takes them."""
        return {
            "recorded_session": _settings(self.recorded_study),
            "replayed_session": _settings(self.study),
            "own_settings": self.is_own,
            "reproduced": self.is_reproduced,
            "partner": self.partner,
            "acted_force": self.acted_force,
            "people_react": False,
            "sides": [side.to_dict() for side in self.sides],
        }

    def __repr__(self) -> str:
        sides = " and ".join(str(side.side) for side in self.sides)
        return f"<Replay of side {sides}: {self.study.session.label}>"


def _settings(study: Study) -> dict[str, Any]:
    """Return what both sides do, as JSON takes it."""
    return {**json_ready(study.session.settings()), "stiffness": study.stiffness}


def seconds_since_start(site: SiteRecording) -> FloatArray:
    """Return the time of every tick since the first one, s."""
    time = np.asarray(site.time, dtype=np.uint64)
    # whole nanoseconds, whose differences are exact
    return 1e-9 * (time - time[:1]).astype(np.float64) if len(time) else np.zeros(0)


def first_difference(site: SiteRecording, own: ReplayedSite) -> float | None:
    """Return from when, s, a replay under the session's own settings differs from the recorded force."""
    differs = np.zeros(len(site.time), dtype=bool)
    is_asked = np.asarray(site.answered) > 0
    for recorded, replayed in ((site.wanted, own.wanted), (site.force, own.force)):
        is_known = is_asked & np.isfinite(recorded).all(axis=1)
        differs |= is_known & (np.asarray(recorded) != replayed).any(axis=1)
    return float(seconds_since_start(site)[np.argmax(differs)]) if differs.any() else None
