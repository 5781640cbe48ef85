"""Results of the core as Python classes: frozen, comparable, picklable, and ready for JSON."""

from __future__ import annotations

import copy
import json
import math
import pickle
import re
from typing import Any

import numpy as np
import pytest

import telespring as ts

K, DELAY = 71.231976, 0.15


def records() -> dict[str, Any]:
    """One of every class, taken from a result."""
    hman = ts.hman()
    damped = ts.Dyad(*hman.robots, coupling_damping=1.0)
    buffered = ts.verdicts(hman, K, DELAY, jitter=0.01, sample_period=0.001)
    nyquist = ts.nyquist(hman, K, DELAY)
    return {
        "verdicts": buffered,
        "verdict": buffered.tier("constant delay"),
        "verdict without a rule": ts.verdicts(damped, K, DELAY).tier("bounded varying delay"),
        "margin": buffered.tier("constant delay").margin,
        "axis verdict": buffered.axes[0],
        "axis tier": buffered.axes[0].tiers[3],
        "operator": buffered.axes[0].tiers[3].operators[0],
        "sampled spectrum": buffered.axes[1].sampled,
        "paper": buffered.paper,
        "budget": buffered.delay_budget[0],
        "remedies": ts.verdicts(hman, 2 * K, DELAY).remedies,
        "stiffness allowed": buffered.stiffness_allowed_behind_buffer,
        "spectrum": ts.certified_roots(hman, K, DELAY),
        "crossing": ts.crossings(hman["x"], K)[0],
        "axis": hman["y"],
        "nyquist": nyquist,
        "frequency margin": nyquist.delay_margin,
        "grid": ts.frequency_grid(hman, K, DELAY, 0.1, 10.0),
        "response": ts.frequency_response(hman, K, DELAY, [1.0, 2.0]),
        "curve": ts.open_loop(hman, K, DELAY, [1.0, 2.0]),
    }


RECORDS = records()
each_record = pytest.mark.parametrize("name", RECORDS)


@each_record
def test_law_a_record_survives_pickling_and_copying(name: str) -> None:
    record = RECORDS[name]
    again = pickle.loads(pickle.dumps(record))
    assert type(again) is type(record)
    assert again == record == copy.deepcopy(record)
    assert (again != record) is False
    assert again.to_dict() == record.to_dict()


@each_record
def test_law_a_record_is_computed_anew_and_equal(name: str) -> None:
    assert records()[name] == RECORDS[name]
    assert RECORDS[name] != 1.0


@each_record
def test_law_a_record_is_ready_for_json(name: str) -> None:
    record = RECORDS[name].to_dict()
    assert json.loads(json.dumps(record, allow_nan=False)) == record


@each_record
def test_law_a_record_cannot_be_changed(name: str) -> None:
    for attribute in RECORDS[name].to_dict():
        with pytest.raises(AttributeError):
            setattr(RECORDS[name], attribute, None)


@each_record
def test_law_the_representation_is_short_and_names_the_class(name: str) -> None:
    text = repr(RECORDS[name])
    assert text.startswith((f"{type(RECORDS[name]).__name__}(", f"<{type(RECORDS[name]).__name__} "))
    assert len(text) < 500


def test_law_small_records_are_hashable() -> None:
    small = [
        RECORDS[name] for name in ("crossing", "paper", "remedies", "axis", "verdict", "margin", "operator")
    ]
    assert len({*small, *(pickle.loads(pickle.dumps(record)) for record in small)}) == len(small)


def test_law_crossings_and_margins_unpack() -> None:
    delay, frequency, direction = RECORDS["crossing"]
    assert RECORDS["crossing"] == (delay, frequency, direction)
    assert (RECORDS["crossing"][0], len(RECORDS["crossing"])) == (delay, 3)
    value, at = RECORDS["frequency margin"]
    assert RECORDS["frequency margin"] == (value, at)
    assert RECORDS["crossing"] != (delay, frequency, -direction)


def test_law_an_array_attribute_is_the_same_array_at_every_read() -> None:
    spectrum = RECORDS["spectrum"]
    assert spectrum.roots is spectrum.roots
    assert RECORDS["nyquist"] != ts.nyquist(ts.hman(), K, DELAY + 1e-9)


def test_law_infinity_and_complex_numbers_have_a_place_in_json() -> None:
    assert ts.verdicts(ts.hman(), 30.0, 0.1).paper.maximum_delay == math.inf
    assert ts.verdicts(ts.hman(), 30.0, 0.1).paper.to_dict()["maximum_delay"] is None
    spectrum = RECORDS["spectrum"]
    np.testing.assert_array_equal(
        spectrum.to_dict()["roots"], np.column_stack([spectrum.roots.real, spectrum.roots.imag])
    )


def test_ref_a_missing_value_is_reported_as_missing() -> None:
    missing = ts.InvalidInput("coupling.stiffness", "", "N/m", "Add stiffness = 20.0.")
    assert str(missing) == "Missing coupling.stiffness (N/m). Add stiffness = 20.0."
    assert str(ts.InvalidInput("robot1", "", "", "Add it.")) == "Missing robot1. Add it."
    with pytest.raises(ts.InvalidInput) as refused:
        ts.Dyad(ts.Robot(-1.0, 1.0), ts.Robot(1.0, 1.0))
    assert str(refused.value) == f"{refused.value.statement} {refused.value.remedy}"


def test_law_a_decision_and_an_identification_show_their_answer() -> None:
    from questions import decide
    from telespring.identification import identify, paper_excitation

    decision = decide(ts.hman(), 71.2, 0.1)
    assert repr(decision).startswith(
        "<Decision status='stable' stiffness=71.2 delay=(0.1, 0.1) stiffness_limit=99.7"
    )
    assert "<caption>Decision</caption>" in decision._repr_html_()
    assert "stable" in decision._repr_html_()

    movement = paper_excitation()
    time = np.arange(15000) / 1000.0
    force = 0.8 * movement.acceleration(time) + 7.7 * movement.velocity(time)
    noise = np.random.default_rng(1).normal(0.0, 0.05, time.size)
    robot = identify(time, movement.position(time), force + noise)
    assert re.fullmatch(r"<Identification x: 0\.8\d* kg, 7\.\d+ N·s/m; 0 warnings>", repr(robot))
    assert "mass" in robot._repr_html_()
