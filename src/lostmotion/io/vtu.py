"""Fields on triangles as VTU files (VTK's XML format for unstructured grids), which ParaView reads.

Source: The VTK User's Guide, 11th ed., "XML file formats": data inline as base64, each behind its
length in bytes.
"""

from __future__ import annotations

import base64
import struct
from typing import TYPE_CHECKING, Any, Final

import numpy as np

if TYPE_CHECKING:
    from collections.abc import Mapping

    from lostmotion.spatial import Floats

_TYPES: Final = {"f4": "Float32", "i4": "Int32", "u1": "UInt8"}
# VTK's number for a triangle.
_TRIANGLE: Final = 5


def vtu(
    points: Floats,
    triangles: np.ndarray[tuple[int, ...], np.dtype[np.int64]],
    fields: Mapping[str, Floats],
) -> bytes:
    """Return a VTU file of plane triangles.

    points     (point, 2)
    triangles  (triangle, 3) numbers of points
    fields     (point,) or (point, 2) by name; vectors get a third component of zero
    """
    count = len(triangles)
    of_points = "".join(_array(name, _in_space(values), "f4") for name, values in fields.items())
    cells = [
        _array("connectivity", triangles.ravel(), "i4"),
        _array("offsets", 3 * np.arange(1, count + 1), "i4"),
        _array("types", np.full(count, _TRIANGLE), "u1"),
    ]
    return (
        '<?xml version="1.0"?>\n<VTKFile type="UnstructuredGrid" version="1.0" '
        'byte_order="LittleEndian" header_type="UInt32">\n'
        f'<UnstructuredGrid>\n<Piece NumberOfPoints="{len(points)}" NumberOfCells="{count}">\n'
        f"<PointData>\n{of_points}</PointData>\n<Points>\n"
        f"{_array('points', _in_space(points), 'f4')}</Points>\n"
        f"<Cells>\n{''.join(cells)}</Cells>\n</Piece>\n</UnstructuredGrid>\n</VTKFile>\n"
    ).encode()


def _in_space(values: Floats) -> Floats:
    return values if values.ndim == 1 else np.column_stack([values, np.zeros(len(values))])


def _array(name: str, values: np.ndarray[Any, Any], kind: str) -> str:
    data = np.ascontiguousarray(values, dtype=f"<{kind}").tobytes()
    text = base64.b64encode(struct.pack("<I", len(data)) + data).decode()
    components = f' NumberOfComponents="{values.shape[1]}"' if values.ndim > 1 else ""
    return (
        f'<DataArray type="{_TYPES[kind]}" Name="{name}"{components} '
        f'format="binary">{text}</DataArray>\n'
    )
