"""Recordings of live sessions: read, put on one time base, and laid out as a rehearsal's trials are."""

from telespring.recording.common_time import CommonTime
from telespring.recording.events import MarkedTrial, SessionEvent
from telespring.recording.merging import merge_recordings
from telespring.recording.reading import is_recording, read_recording
from telespring.recording.session import SessionRecording
from telespring.recording.side import SideRecording

__all__ = [
    "CommonTime",
    "MarkedTrial",
    "SessionEvent",
    "SessionRecording",
    "SideRecording",
    "is_recording",
    "merge_recordings",
    "read_recording",
]
