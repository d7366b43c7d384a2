"""The geometry of a calibrated robot as files for other programs: a URDF, and a table of modified
Denavit-Hartenberg values.
"""

from __future__ import annotations

import csv
import io
from typing import TYPE_CHECKING
from xml.sax.saxutils import quoteattr

import numpy as np

from lostmotion.io.dh import rpy_of

if TYPE_CHECKING:
    from lostmotion.calibration.geometry import ExactChain, MdhTable
    from lostmotion.spatial import Floats

_NOTE = (
    "Geometry of one calibrated robot: constant errors alone. Limits of effort and velocity are "
    "not known here."
)


def urdf_text_of(name: str, chain: ExactChain, limits: Floats) -> str:
    """Return a URDF with the origins and axes of a chain, and its tool; limits: (joint, 2)."""
    links = ["base", *(f"{joint}_link" for joint in chain.joints), "tool"]
    lines = ['<?xml version="1.0"?>', f"<!-- {_NOTE} -->", f"<robot name={quoteattr(name)}>"]
    lines += [f"  <link name={quoteattr(link)}/>" for link in links]
    for k, step in enumerate(chain.steps):
        joint = chain.joints[k] if k < len(chain.axes) else "tool_joint"
        axis = chain.axes[k] if k < len(chain.axes) else np.zeros(6)
        turns = axis[:3].any()
        kind = "fixed" if not axis.any() else "revolute" if turns else "prismatic"
        lines += [
            f"  <joint name={quoteattr(joint)} type={quoteattr(kind)}>",
            f"    <parent link={quoteattr(links[k])}/>",
            f"    <child link={quoteattr(links[k + 1])}/>",
            f'    <origin xyz="{_numbers(step[:3, 3])}" rpy="{_numbers(rpy_of(step[:3, :3]))}"/>',
        ]
        if kind != "fixed":
            low, high = map(float, limits[k])
            lines += [
                f'    <axis xyz="{_numbers(axis[:3] if turns else axis[3:])}"/>',
                f'    <limit lower="{low!r}" upper="{high!r}" effort="0" velocity="0"/>',
            ]
        lines.append("  </joint>")
    return "\n".join([*lines, "</robot>"]) + "\n"


def mdh_text(chain: ExactChain, table: MdhTable) -> str:
    """Return a CSV of modified Denavit-Hartenberg values, with base and tool frame above it."""
    lines = [
        "# Geometry of one calibrated robot: constant errors alone.",
        "# Frame i in frame i-1: Rx(alpha) Tx(a) Rz(theta + q) Tz(d).",
        *(
            f"# {name}: xyz {_numbers(1e3 * frame[:3, 3])} mm, "
            f"rpy {_numbers(np.degrees(rpy_of(frame[:3, :3])))} deg"
            for name, frame in (("frame 0 in the base", table.base), ("tool", table.tool))
        ),
        "joint,a [mm],alpha [deg],d [mm],theta [deg]",
    ]
    out = io.StringIO()
    writer = csv.writer(out, lineterminator="\n")
    for joint, (a, alpha, d, theta) in zip(chain.joints, table.rows, strict=True):
        values = (1e3 * a, np.degrees(alpha), 1e3 * d, np.degrees(theta))
        writer.writerow([joint, *(repr(float(each)) for each in values)])
    return "\n".join([*lines, out.getvalue()])


def _numbers(values: Floats | tuple[float, ...]) -> str:
    return " ".join(repr(float(each)) for each in values)
