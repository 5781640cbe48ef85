"""Variables of a MATLAB file as arrays, texts, structs (dict) and cells (list): all versions up to 7.3."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np

__all__ = ["named_arrays", "read_matlab_variables"]

#: Since version 7.3 a MATLAB file is an HDF5 file behind a block of text.
_HDF5_SIGNATURE = b"\x89HDF\r\n\x1a\n"
_TEXT_BLOCK = 512
_NUMBERS = "biuf"


def read_matlab_variables(path: Path) -> dict[str, Any]:
    """Read the variables of a MATLAB file.

    Matrices have rows first, as in MATLAB; vectors have one dimension. Objects of classes, such as
    `timeseries` or `datetime`, are None: their format is not published. Any error of the parser shows a
    damaged file.
    """
    with path.open("rb") as file:
        beginning = file.read(_TEXT_BLOCK + len(_HDF5_SIGNATURE))
    if beginning.startswith(_HDF5_SIGNATURE) or beginning.endswith(_HDF5_SIGNATURE):
        return _read_version_7_3(path)
    from scipy import io

    content = io.loadmat(path, simplify_cells=True)
    return {name: _plain(value) for name, value in content.items() if not name.startswith("__")}


def _plain(value: Any) -> Any:
    """Convert what scipy returns for a variable: arrays of structs and cells become lists."""
    if isinstance(value, dict):
        return {name: _plain(inner) for name, inner in value.items()}
    if isinstance(value, list):
        return [_plain(inner) for inner in value]
    if isinstance(value, np.ndarray) and value.dtype.names is not None:
        return None  # an object of a class
    if isinstance(value, np.ndarray) and value.dtype == object:
        return [_plain(inner) for inner in value.ravel()]
    return value


def _read_version_7_3(path: Path) -> dict[str, Any]:
    import h5py

    with h5py.File(path, "r") as file:
        return {name: _convert_hdf5(file, item) for name, item in file.items() if not name.startswith("#")}


def _convert_hdf5(file: Any, item: Any) -> Any:
    """Convert a group or dataset of a MATLAB file to what `read_matlab_variables` returns."""
    import h5py

    kind = item.attrs.get("MATLAB_class", b"")
    kind = kind.decode() if isinstance(kind, bytes) else str(kind)
    if isinstance(item, h5py.Group):
        if "MATLAB_object_decode" in item.attrs or "MATLAB_sparse" in item.attrs:
            return None
        fields = {name: _convert_hdf5(file, inner) for name, inner in item.items()}
        lengths = {len(inner) if isinstance(inner, _Elements) else 0 for inner in fields.values()}
        # In an array of structs each field is an array of references.
        if len(lengths) == 1 and lengths != {0}:
            return [{name: inner[i] for name, inner in fields.items()} for i in range(lengths.pop())]
        return {
            name: list(inner) if isinstance(inner, _Elements) else inner for name, inner in fields.items()
        }
    if "MATLAB_object_decode" in item.attrs:
        return None
    if item.attrs.get("MATLAB_empty", 0):
        return "" if kind == "char" else np.empty(0)
    if item.dtype == h5py.ref_dtype:
        elements = [_convert_hdf5(file, file[reference]) for reference in np.ravel(item[()])]
        return elements if kind == "cell" else _Elements(elements)
    values = np.asarray(item[()])
    if kind == "char":
        return "".join(map(chr, np.ravel(values)))
    if values.dtype.kind not in _NUMBERS:
        return None
    # MATLAB writes columns first, HDF5 reads rows first.
    return np.squeeze(values.T)


class _Elements(list[Any]):
    """The values of one field in all elements of an array of structs."""


def named_arrays(variables: dict[str, Any]) -> tuple[dict[str, Any], list[str]]:
    """Name every array of numbers by its path, and list the names of other things.

    Fields are named `struct.field`, elements of arrays of structs and of cells `runs[0].time`, columns of a
    matrix `matrix[0]`. A signal of Simulink's "structure with time" is also named by its label: `out.force`.
    """
    arrays: dict[str, Any] = {}
    others: list[str] = []
    for name, value in variables.items():
        _name_arrays(name, value, arrays, others)
    return arrays, others


def _name_arrays(name: str, value: Any, arrays: dict[str, Any], others: list[str]) -> None:
    if isinstance(value, dict):
        for field, inner in value.items():
            _name_arrays(f"{name}.{field}", inner, arrays, others)
        if "time" in value and "signals" in value:
            for label, signal in _labelled_signals(value["signals"]).items():
                if label not in value:
                    _name_arrays(f"{name}.{label}", signal, arrays, others)
    elif isinstance(value, list):
        for i, inner in enumerate(value):
            _name_arrays(f"{name}[{i}]", inner, arrays, others)
    elif value is None or np.asarray(value).dtype.kind not in _NUMBERS:
        if not isinstance(value, str):
            others.append(name)
    else:
        arrays |= _columns(name, np.asarray(value))


def _columns(name: str, array: Any) -> dict[str, Any]:
    """Name the columns of a matrix; the time is the longest dimension, or the last of three."""
    if array.ndim > 2:
        array = array.reshape(-1, array.shape[-1])
    if array.ndim < 2:
        return {name: array.ravel()}
    if 1 in array.shape:
        return {name: array.ravel()}
    tall = array if array.shape[0] > array.shape[1] else array.T
    return {f"{name}[{i}]": tall[:, i] for i in range(tall.shape[1])}


def _labelled_signals(signals: Any) -> dict[str, Any]:
    """Return the values of Simulink's signals by their labels."""
    labelled = {}
    for signal in signals if isinstance(signals, list) else [signals]:
        if isinstance(signal, dict) and isinstance(signal.get("label"), str) and signal["label"]:
            labelled[signal["label"]] = signal.get("values")
    return labelled
