"""States of a packing as files of VTK's XML formats, which ParaView opens: particles, contacts, and the series of them."""

from __future__ import annotations

import base64
import struct
from collections.abc import Mapping, Sequence
from pathlib import Path
from xml.sax.saxutils import quoteattr

import numpy as np
from numpy.typing import NDArray

_TYPES = {"float64": "Float64", "int64": "Int64"}


def write_particles(path: Path, positions: NDArray[np.float64], radii: NDArray[np.float64]) -> None:
    """Points at the centres (N, 3) in m, with their radius."""
    count = len(positions)
    verts = {"connectivity": np.arange(count), "offsets": np.arange(1, count + 1)}
    _write_polydata(path, positions, "Verts", verts, {"radius": radii}, {})


def write_contacts(path: Path, begins: NDArray[np.float64], ends: NDArray[np.float64], data: Mapping[str, NDArray[np.float64]]) -> None:
    """A line for each contact, from (C, 3) to (C, 3) in m, with data of each, (C,) or (C, 3)."""
    count = len(begins)
    points = np.stack([begins, ends], axis=1).reshape(-1, 3)
    lines = {"connectivity": np.arange(2 * count), "offsets": np.arange(2, 2 * count + 1, 2)}
    _write_polydata(path, points, "Lines", lines, {}, data)


def write_series(path: Path, names: Sequence[str], times: Sequence[float]) -> None:
    """A .pvd file that names files beside it, each with its time: here, whatever the series runs along."""
    sets = "".join(f'<DataSet timestep="{time!r}" part="0" file={quoteattr(name)}/>\n' for name, time in zip(names, times, strict=True))
    path.write_text(
        f'<?xml version="1.0"?>\n<VTKFile type="Collection" version="1.0" byte_order="LittleEndian">\n<Collection>\n{sets}</Collection>\n</VTKFile>\n',
        encoding="utf-8",
    )


def _write_polydata(
    path: Path,
    points: NDArray[np.float64],
    kind: str,
    cells: Mapping[str, NDArray[np.int64]],
    of_points: Mapping[str, NDArray],
    of_cells: Mapping[str, NDArray],
) -> None:
    count = len(cells["offsets"])
    parts = [
        f"<Points>\n{_array('points', points)}</Points>\n",
        f"<{kind}>\n{''.join(_array(name, values) for name, values in cells.items())}</{kind}>\n",
        f"<PointData>\n{''.join(_array(name, values) for name, values in of_points.items())}</PointData>\n",
        f"<CellData>\n{''.join(_array(name, values) for name, values in of_cells.items())}</CellData>\n",
    ]
    head = '<?xml version="1.0"?>\n<VTKFile type="PolyData" version="1.0" byte_order="LittleEndian" header_type="UInt64">\n<PolyData>\n'
    piece = f'<Piece NumberOfPoints="{len(points)}" NumberOf{kind}="{count}">\n'
    path.write_text(f"{head}{piece}{''.join(parts)}</Piece>\n</PolyData>\n</VTKFile>\n", encoding="utf-8")


def _array(name: str, values: NDArray) -> str:
    """The number of bytes and the bytes themselves, in base64."""
    values = np.ascontiguousarray(values, dtype="<i8" if values.dtype.kind == "i" else "<f8")
    data = values.tobytes()
    text = base64.b64encode(struct.pack("<Q", len(data)) + data).decode()
    components = values.shape[1] if values.ndim == 2 else 1
    return f'<DataArray type="{_TYPES[values.dtype.name]}" Name={quoteattr(name)} NumberOfComponents="{components}" format="binary">\n{text}\n</DataArray>\n'
