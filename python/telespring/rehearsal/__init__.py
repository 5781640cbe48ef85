"""A study's protocol run on the virtual laboratory, and kept in a folder as one dataset.

`docs/rehearse.md` describes the dataset, the folder, and agents and targets written in Python.
"""

from telespring.rehearsal.run import RehearsalOutcome, rehearse, run_protocol

__all__ = ["RehearsalOutcome", "rehearse", "run_protocol"]
