"""A study's whole protocol on the virtual laboratory, kept as one labelled dataset.

The dataset, the folder it is made in and agents and targets written in Python are described in
`docs/rehearse.md`.
"""

from telespring.rehearsal.run import Outcome, rehearse, run_protocol

__all__ = ["Outcome", "rehearse", "run_protocol"]
