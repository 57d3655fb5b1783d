"""Arrays as bytes for the store: NumPy's own .npy format, which any NumPy reads back with every bit; nothing in it is executed."""

from __future__ import annotations

import io
from collections.abc import Mapping

import numpy as np
from numpy.lib import format as npy
from numpy.typing import NDArray


def pack_array(array: NDArray) -> bytes:
    """An array as bytes."""
    buffer = io.BytesIO()
    # The version whose header holds any name, in UTF-8.
    npy.write_array(buffer, array, version=(3, 0), allow_pickle=False)
    return buffer.getvalue()


def unpack_array(blob: bytes) -> NDArray:
    """The array that `pack_array` made bytes of, read-only."""
    array = npy.read_array(io.BytesIO(blob), allow_pickle=False, max_header_size=len(blob))
    array.setflags(write=False)
    return array


def pack_columns(columns: Mapping[str, NDArray[np.float64]]) -> bytes:
    """Named columns of equal length (T,) as the bytes of one structured array."""
    table = np.empty(len(next(iter(columns.values()))), dtype=[(name, "<f8") for name in columns])
    for name, values in columns.items():
        table[name] = values
    return pack_array(table)


def unpack_columns(blob: bytes) -> dict[str, NDArray[np.float64]]:
    """The columns that `pack_columns` made bytes of, by name."""
    table = unpack_array(blob)
    if table.dtype.names is None:
        raise ValueError("named columns were expected")
    return {name: np.ascontiguousarray(table[name]) for name in table.dtype.names}
