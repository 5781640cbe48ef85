"""The live program `telespring-link`: found, started, watched and asked to leave.

`docs/connect.md` describes the program, its console and its summary.
"""

from telespring.connection.outcome import outcome, recording_path
from telespring.connection.program import find_program
from telespring.connection.running import RunningProgram
from telespring.connection.session import Line, LiveSession, Side

__all__ = ["Line", "LiveSession", "RunningProgram", "Side", "find_program", "outcome", "recording_path"]
