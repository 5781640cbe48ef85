"""Logs in MATLAB files of both formats: arrays, structs, arrays of structs, cells, Simulink's output."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import h5py
import numpy as np
import pytest
from scipy import io

from telespring import InvalidInput
from telespring.identification import read_log

TIME = np.arange(60) / 1000.0
RANDOM = np.random.default_rng(73)
POSITION, FORCE = RANDOM.normal(0.0, 0.1, (60, 2)), RANDOM.normal(0.0, 2.0, (60, 2))


class Version73:
    """Writes variables as MATLAB's save(..., '-v7.3') does: columns first, texts as numbers, references."""

    def __init__(self, path: Path) -> None:
        self.file = h5py.File(path, "w", userblock_size=512)
        self.references = self.file.create_group("#refs#")
        self.path = path

    def save(self, variables: dict[str, Any]) -> Path:
        for name, value in variables.items():
            self.write(self.file, name, value)
        self.file.close()
        with self.path.open("r+b") as file:
            file.write(b"MATLAB 7.3 MAT-file, Platform: GLNXA64, HDF5 schema 1.00 .".ljust(116) + bytes(8))
            file.write(b"\x00\x02IM")
        return self.path

    def write(self, group: h5py.Group, name: str, value: Any) -> Any:
        if isinstance(value, dict):
            item = group.create_group(name)
            item.attrs["MATLAB_class"] = np.bytes_("struct")
            for field, inner in value.items():
                self.write(item, field, inner)
        elif isinstance(value, tuple):  # an array of structs
            item = group.create_group(name)
            item.attrs["MATLAB_class"] = np.bytes_("struct")
            for field in value[0]:
                self.refer(item, field, [element[field] for element in value])
        elif isinstance(value, list):  # a cell array
            item = self.refer(group, name, value)
            item.attrs["MATLAB_class"] = np.bytes_("cell")
        elif isinstance(value, str):
            letters = np.array([[ord(letter)] for letter in value], dtype=np.uint16)
            item = group.create_dataset(name, data=letters if value else np.array([0, 0], dtype=np.uint64))
            item.attrs["MATLAB_class"] = np.bytes_("char")
            item.attrs["MATLAB_int_decode"] = 2
            if not value:
                item.attrs["MATLAB_empty"] = 1
        else:
            array = np.asarray(value)
            # vectors are columns (n,1) in MATLAB, and (1, n) in HDF5
            array = array.reshape(1, 1) if array.ndim == 0 else array[:, None] if array.ndim == 1 else array
            item = group.create_dataset(name, data=array.T)
            item.attrs["MATLAB_class"] = np.bytes_("double" if array.dtype.kind == "f" else array.dtype.name)
        return item

    def refer(self, group: h5py.Group, name: str, values: list[Any]) -> Any:
        items = [self.write(self.references, f"{len(self.references)}", value) for value in values]
        data = np.array([[item.ref] for item in items], dtype=h5py.ref_dtype)
        return group.create_dataset(name, data=data, dtype=h5py.ref_dtype)


def as_scipy(value: Any) -> Any:
    """Convert to what `savemat` writes as the same variables."""
    if isinstance(value, dict):
        return {name: as_scipy(inner) for name, inner in value.items()}
    if isinstance(value, tuple):
        kind = [(name, object) for name in value[0]]
        return np.array(
            [[tuple(as_scipy(inner) for inner in element.values())] for element in value], dtype=kind
        )
    if isinstance(value, list):
        cells = np.empty((len(value), 1), dtype=object)
        for i, inner in enumerate(value):
            cells[i, 0] = as_scipy(inner)
        return cells
    return np.asarray(value)[:, None] if isinstance(value, np.ndarray) and value.ndim == 1 else value


def save(path: Path, variables: dict[str, Any], version: str) -> Path:
    if version == "7.3":
        return Version73(path).save(variables)
    io.savemat(
        path, {name: as_scipy(value) for name, value in variables.items()}, do_compression=version == "7"
    )
    return path


PLAIN = {"time": TIME, "position_x": POSITION[:, 0], "position_y": POSITION[:, 1]}
PLAIN |= {"force_x": FORCE[:, 0], "force_y": FORCE[:, 1]}
#: Simulink's "structure with time", as To Workspace writes it.
SIGNALS: tuple[dict[str, Any], ...] = (
    {"values": POSITION, "dimensions": np.array([2.0]), "label": "position", "blockName": "rig/Scope"},
    {"values": FORCE, "dimensions": np.array([2.0]), "label": "force", "blockName": "rig/Scope"},
)
SIMULINK = {"time": TIME, "signals": SIGNALS, "blockName": "rig/Scope"}
MATRIX = {"data": np.column_stack([TIME, POSITION, FORCE])}
RUN = {"t": TIME, "x": POSITION, "f": FORCE, "note": "first"}
FILES: dict[str, tuple[dict[str, Any], str, tuple[str, str], tuple[str, str]]] = {
    "arrays": (PLAIN, "time", ("position_x", "position_y"), ("force_x", "force_y")),
    "arrays, a text and a scalar": (
        {"name": "robot A", "empty": "", "rate": 1000.0} | PLAIN,
        "time",
        ("position_x", "position_y"),
        ("force_x", "force_y"),
    ),
    "a matrix": (MATRIX, "data[0]", ("data[1]", "data[2]"), ("data[3]", "data[4]")),
    "rows": (
        {"time": TIME[None], "x": POSITION.T.copy(), "f": FORCE.T.copy()},
        "time",
        ("x[0]", "x[1]"),
        ("f[0]", "f[1]"),
    ),
    "a struct": (
        {"log": PLAIN},
        "log.time",
        ("log.position_x", "log.position_y"),
        ("log.force_x", "log.force_y"),
    ),
    "structs in structs": (
        {"rig": {"robot": {"sensors": RUN | {"rate": 1000.0}}, "day": "Monday"}},
        "rig.robot.sensors.t",
        ("rig.robot.sensors.x[0]", "rig.robot.sensors.x[1]"),
        ("rig.robot.sensors.f[0]", "rig.robot.sensors.f[1]"),
    ),
    "an array of structs": (
        {"runs": ({"t": TIME[:20], "x": POSITION[:20], "f": FORCE[:20], "note": "short"}, RUN)},
        "runs[1].t",
        ("runs[1].x[0]", "runs[1].x[1]"),
        ("runs[1].f[0]", "runs[1].f[1]"),
    ),
    "cells": (
        {"t": TIME, "cells": ["a", POSITION, FORCE]},
        "t",
        ("cells[1][0]", "cells[1][1]"),
        ("cells[2][0]", "cells[2][1]"),
    ),
    "Simulink's structure with time": (
        {"out": SIMULINK},
        "out.time",
        ("out.signals[0].values[0]", "out.signals[0].values[1]"),
        ("out.signals[1].values[0]", "out.signals[1].values[1]"),
    ),
    "Simulink's labels": (
        {"out": SIMULINK},
        "out.time",
        ("out.position[0]", "out.position[1]"),
        ("out.force[0]", "out.force[1]"),
    ),
    "Simulink with one signal": (
        {
            "out": {
                "time": TIME,
                "signals": SIGNALS[0] | {"label": "all", "values": np.hstack([POSITION, FORCE])},
            }
        },
        "out.time",
        ("out.all[0]", "out.all[1]"),
        ("out.all[2]", "out.all[3]"),
    ),
    "whole nanoseconds": (
        PLAIN | {"time": 1_711_846_799_987_300_000 + 1_000_000 * np.arange(60)},
        "time",
        ("position_x", "position_y"),
        ("force_x", "force_y"),
    ),
}


@pytest.mark.parametrize("version", ["5", "7", "7.3"])
@pytest.mark.parametrize("kind", FILES)
def test_law_a_matlab_file_gives_the_same_numbers(kind: str, version: str, tmp_path: Path) -> None:
    variables, time, position, force = FILES[kind]
    path = save(tmp_path / "log.MAT", variables, version)
    log = read_log(path, time=time, position=position, force=force)
    np.testing.assert_allclose(log.time, TIME, rtol=0.0, atol=1e-15)
    np.testing.assert_array_equal(log.position, POSITION)
    np.testing.assert_array_equal(log.force, FORCE)


@pytest.mark.parametrize("version", ["5", "7.3"])
def test_law_signals_of_matrices_have_the_time_last(version: str, tmp_path: Path) -> None:
    """Simulink writes a signal of 1 by 2 over time as 1 by 2 by n."""
    out = {"time": TIME, "signals": {"values": np.hstack([POSITION, FORCE]).T[None], "label": ""}}
    path = save(tmp_path / "log.mat", {"out": out}, version)
    column = "out.signals.values[{}]".format
    log = read_log(path, time="out.time", position=[column(0), column(1)], force=[column(2), column(3)])
    np.testing.assert_array_equal(log.position, POSITION)
    np.testing.assert_array_equal(log.force, FORCE)


@pytest.mark.parametrize("version", ["5", "7.3"])
def test_law_arrays_of_other_lengths_are_refused_only_if_named(version: str, tmp_path: Path) -> None:
    path = save(tmp_path / "log.mat", PLAIN | {"long": np.arange(500.0)}, version)
    assert len(read_log(path).time) == 60
    with pytest.raises(
        InvalidInput, match="long, 500 values: one value per sample is required, and time has 60"
    ):
        read_log(path, position=["long", "position_y"])


@pytest.mark.parametrize("version", ["5", "7.3"])
def test_law_a_file_without_numbers_says_what_it_has(version: str, tmp_path: Path) -> None:
    path = save(tmp_path / "log.mat", {"name": "robot A", "notes": ["one", "two"]}, version)
    with pytest.raises(InvalidInput, match="arrays of numbers are required"):
        read_log(path)


def test_law_objects_of_classes_are_named_as_what_cannot_be_read(tmp_path: Path) -> None:
    """MATLAB marks a `timeseries` or `datetime` in a file of version 7.3 as an object."""
    path = tmp_path / "log.mat"
    writer = Version73(path)
    item = writer.file.create_dataset("series", data=np.array([[3_707_764_736, 2, 1, 1]], dtype=np.uint32))
    item.attrs["MATLAB_class"] = np.bytes_("timeseries")
    item.attrs["MATLAB_object_decode"] = 3
    writer.save({})
    with pytest.raises(InvalidInput, match="only other things: series") as refused:
        read_log(path)
    assert "Structure With Time" in refused.value.remedy


def test_law_a_damaged_file_is_refused(tmp_path: Path) -> None:
    path = save(tmp_path / "log.mat", PLAIN, "7.3")
    path.write_bytes(path.read_bytes()[:3000])
    with pytest.raises(InvalidInput, match="cannot be read as one"):
        read_log(path)
