"""A recorded live session through its endpoints once more, under the same or another control architecture.

`docs/recording.md` says what a replay tells, and what it cannot.
"""

from telespring.replays.results import Replay, SideNumbers, SideReplay
from telespring.replays.run import replay
from telespring.replays.sites import SiteRecording

__all__ = ["Replay", "SideNumbers", "SideReplay", "SiteRecording", "replay"]
