"""What BIDS files say of themselves: the sidecars of a run, the columns of tables, the dataset."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Any

from telespring._core import __version__
from telespring.exchange.bids.channels import KINDS, Channel
from telespring.exchange.bids.runs import Run

__all__ = [
    "BIDS_VERSION",
    "CHANNELS",
    "EVENTS",
    "PARTICIPANTS",
    "README",
    "SCANS",
    "dataset_description",
    "motion_sidecar",
]

#: The version of the specification that the files follow.
BIDS_VERSION = "1.11.1"

README = """\
Two people, each at a robot, coupled by a virtual spring; recorded together. Written by telespring.

Each person is a subject. Those who were coupled have the same label of the session, task, acquisition and
run, and their motion files have the same number of samples: line n of both is the same instant. `scans.tsv`
says so of each file: `concurrent_with` names the partner's file, `dyad` both people, `acq_time` the same
time, and `clock_uncertainty` how exact that common time is.

A live session is one run, whose trials are lines of its events file; a trial that was recorded by itself is a
run. In the names of channels x and y are the axes of the robots' plane. Units are SI.
"""

PARTICIPANTS: dict[str, Any] = {"participant_id": {"Description": "label of the person"}}

SCANS: dict[str, Any] = {
    "filename": {"Description": "the file"},
    "acq_time": {"Description": "time of the first sample, UTC; the same for both people of a dyad"},
    "duration": {"Description": "duration of the recording", "Units": "s"},
    "concurrent_with": {"Description": "file of the partner; its samples are those of the same instants"},
    "dyad": {"Description": "label of the two people who were coupled"},
    "robot": {"Description": "the robot of the study that the person held, 1 or 2"},
    "clock_uncertainty": {
        "Description": "largest error of the common time of both people; 0 where one clock stamped both",
        "Units": "s",
    },
    "clock_scatter": {
        "Description": "how much the comparisons of both clocks scatter, where no largest error is known",
        "Units": "s",
    },
    "simulated": {
        "Description": "whether a simulation made the recording",
        "Levels": {"true": "no person took part", "false": "people took part, or who did is not known"},
    },
}

EVENTS: dict[str, Any] = {
    "onset": {"Description": "when, from the first sample of the run", "Units": "s"},
    "duration": {"Description": "how long; 0 for an instant", "Units": "s"},
    "trial_type": {"Description": "trial, or what happened in the session, in a word"},
    "value": {"Description": "label of the trial, or why it happened"},
    "robot": {"Description": "the robot at whose site it happened; n/a for both"},
    "condition": {"Description": "condition of the trial"},
    "stiffness": {"Description": "stiffness of the virtual spring; n/a if there is none", "Units": "N/m"},
    "delay": {
        "Description": "one-way delay; in a live session the median age of the partner's motion in use",
        "Units": "s",
    },
    "status": {"Description": "how the trial ended"},
}

CHANNELS: dict[str, Any] = {
    "reference_frame": {
        "Levels": {
            "study": {
                "Description": "plane of the handles, the same for both robots; the study defines its origin",
                "RotationRule": "right-hand",
            }
        }
    }
}


def dataset_description(name: str) -> dict[str, Any]:
    """Describe the dataset."""
    return {
        "Name": name,
        "BIDSVersion": BIDS_VERSION,
        "DatasetType": "raw",
        "GeneratedBy": [{"Name": "telespring", "Version": __version__}],
    }


def motion_sidecar(
    run: Run, robot: int, task: str, channels: Sequence[Channel], study: str
) -> dict[str, Any]:
    """Describe the motion of one robot (0 or 1) in a run."""
    counts = {kind: sum(channel.kind == kind for channel in channels) for kind in KINDS}
    described = {
        "TaskName": task,
        "TaskDescription": "Two people move robots that a virtual spring couples over a network with delay.",
        # Both people's samples lie on one even clock. A tool that takes the effective frequency for the time
        # of a line must find that clock, and not how often each site ticked.
        "SamplingFrequency": _printed(1.0 / run.period),
        "SamplingFrequencyEffective": _printed(1.0 / run.period),
        "RecordingDuration": _printed(run.duration),
        "MotionChannelCount": counts["POS"] + counts["VEL"],
        "POSChannelCount": counts["POS"],
        "VELChannelCount": counts["VEL"],
        "MISCChannelCount": counts["MISC"],
        "ACCELChannelCount": 0,
        "ANGACCELChannelCount": 0,
        "GYROChannelCount": 0,
        "JNTANGChannelCount": 0,
        "LATENCYChannelCount": counts["LATENCY"],
        "MAGNChannelCount": 0,
        "ORNTChannelCount": 0,
        "TrackedPointsCount": len({channel.tracked_point for channel in channels} - {"n/a"}),
        "TrackingSystemName": f"robot {robot + 1}",
        "MissingValues": "n/a",
        "SubjectArtefactDescription": "n/a",
        "SoftwareVersions": f"telespring {__version__}",
    }
    if math.isfinite(run.rates[robot]):
        described["TickFrequency"] = _printed(run.rates[robot])
    if study:
        described["Study"] = study
    return described


def _printed(value: float) -> float | str:
    """Return a number with the digits of the tables, without those that a division has left."""
    return float(f"{value:.10g}") if math.isfinite(value) else "n/a"
