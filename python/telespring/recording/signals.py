"""The signals of a live session: their names, units and meaning in a dataset.

A quantity that a rehearsal has, too, has its name, unit and meaning.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal

__all__ = ["SIGNALS", "TARGET", "WORDS", "LiveSignal"]

#: How a signal goes on between two ticks: motions move, what was decided holds.
Between = Literal["linear", "held"]


@dataclass(frozen=True)
class LiveSignal:
    """A signal of one side over time.

    Attributes
    ----------
    name, units, long_name
        Of the variable in the dataset.
    fields
        Of a tick in the recording: one, or one for each axis.
    between
        Whether it is interpolated between ticks or held.
    """

    name: str
    units: str
    long_name: str
    fields: tuple[str, ...]
    between: Between = "held"

    @property
    def has_axes(self) -> bool:
        """Whether there is a value for each axis."""
        return len(self.fields) == 2


def _axes(field: str) -> tuple[str, str]:
    return f"{field}.x", f"{field}.y"


SIGNALS = (
    # as in a rehearsal
    LiveSignal("position", "m", "position of the handle", _axes("own.position"), "linear"),
    LiveSignal("velocity", "m/s", "velocity of the handle", _axes("own.velocity"), "linear"),
    LiveSignal("coupling_force", "N", "force of the virtual spring on the handle", _axes("commanded_force")),
    LiveSignal("account", "J", "energy in the account of the side's strategy", ("energy_balance",)),
    LiveSignal("age", "s", "age of the oldest partner's sample that a robot uses", ("age",)),
    # of live sessions only
    LiveSignal(
        "wanted_force", "N", "force of the spring before the limits of the site", _axes("wanted_force")
    ),
    LiveSignal(
        "acted_force", "N", "force that acted until then, as the account takes it", _axes("acted_force")
    ),
    LiveSignal(
        "measured_force", "N", "force on the handle as the device measured it", _axes("measured_force")
    ),
    LiveSignal(
        "own_target", "m", "target that the person at this robot saw", _axes("target.position"), "linear"
    ),
    LiveSignal(
        "played_position", "m", "position of the partner in use, as played", _axes("partner_played.position")
    ),
    LiveSignal(
        "predicted_position", "m", "position to which the spring pulls", _axes("partner_predicted.position")
    ),
    LiveSignal("wanted_stiffness", "N/m", "stiffness of the study", ("stiffness_wanted",)),
    LiveSignal("stiffness_in_use", "N/m", "stiffness in use", ("stiffness",)),
    LiveSignal("is_limited", "1", "whether the strategy changed the force of the spring", ("is_limited",)),
    LiveSignal("watchdog_factor", "1", "factor of the watchdog on the force", ("watchdog_factor",)),
    LiveSignal("energy_given_out", "J", "energy given out to the handle so far", ("energy_given_out",)),
    LiveSignal("total_energy_sent", "J", "energy sent to the partner so far", ("energy_sent",)),
    LiveSignal("energy_received", "J", "energy taken in from the partner so far", ("energy_received",)),
    LiveSignal("playout_delay", "s", "delay that the play-out strives for", ("playout_delay",)),
    LiveSignal("round_trip", "s", "latest round trip", ("round_trip",)),
    LiveSignal("lateness", "s", "how late the loop woke up", ("lateness",)),
    LiveSignal("tick_duration", "s", "duration of the tick", ("duration",)),
    LiveSignal("latency_device", "s", "latency of the device beyond its shortest", ("latency_device",)),
    LiveSignal(
        "latency_loop", "s", "from the time at which a tick was due to its command", ("latency_loop",)
    ),
    LiveSignal("latency_network", "s", "from the partner's measurement to its arrival", ("latency_network",)),
    LiveSignal("latency_playout", "s", "from the arrival of a motion to its use", ("latency_playout",)),
    LiveSignal("packets_received", "1", "packets of the partner so far", ("packets_received",)),
    LiveSignal("packets_lost", "1", "packets that had not come although later ones had", ("packets_lost",)),
    LiveSignal("held_ticks", "1", "ticks so far at which an old motion was held", ("held_ticks",)),
)
#: The target of both people.
TARGET = LiveSignal("target", "m", "position of the target", _axes("target.position"), "linear")
#: Words of every tick, and their meaning.
WORDS = {
    "phase": "state of the session",
    "watchdog": "state of the watchdog",
}
