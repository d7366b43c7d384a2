"""The arm at its worst and at its best pose in a cut through its workspace, coloured by the error:
the pictures of the first screen.
"""

from __future__ import annotations

import functools
import math
from dataclasses import dataclass
from typing import TYPE_CHECKING, Final

import numpy as np

from lostmotion.error_model.pose_matrix import pose_matrix
from lostmotion.mechanism.state import state_of
from lostmotion.printed import factor_of, unit_of_length
from lostmotion.reporting.arm_scene import ArmScene, Cells, ShownPose
from lostmotion.reporting.chart import label_axes, one
from lostmotion.reporting.map_chart import cells, class_legend, class_of
from lostmotion.reporting.palette import LIGHT, class_limits, round_below
from lostmotion.reporting.plot import FIRST_SCREEN, Plot
from lostmotion.reporting.section import COVERED, FLAT, PoseValues, symmetry_axis
from lostmotion.reporting.sheet import length
from lostmotion.reporting.workspace_cells import CELLS, NEAREST, cells_in_space, cells_of_cut

if TYPE_CHECKING:
    from collections.abc import Iterator, Sequence

    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

    from lostmotion.mechanism.arm import Arm
    from lostmotion.spatial import Floats

# The enlarged error is at most this share of the longest side of the workspace long.
_ERROR: Final = 0.15
# The mean error vector is drawn where its part in the plane of the cut is more than this share of
# it.
_SHOWN: Final = 0.2
# Semi-axis over standard deviation of the ellipsoid that contains 95 % of a normal vector: root of
# the quantile of chi-square with three degrees.
_WITHIN_95: Final = 2.7955
_FILLS: Final = {"base": "quiet", "joint": "quiet", "tool": "warn", "payload": "warn"}
_MEANING: Final = {
    "worst": "the pose with the largest mean error",
    "best": "the pose with the smallest mean error",
}
_WHAT: Final = "95 % of positions within"


@dataclass(frozen=True)
class PicturedErrors:
    """The error of an arm at each of its poses, for a picture.

    q          (pose, joint) rad or m
    approach   sign of the joints' last motion
    tool       (pose, 3) m, where each pose puts the tool
    mean       (pose,) mean error, m
    within     (pose,) 95th percentile of the error, m
    reachable  (point, 3) m, what the tool reaches within the joint limits
    target     largest acceptable error, m; None without one
    """

    arm: Arm
    q: Floats
    approach: float
    tool: Floats
    mean: Floats
    within: Floats
    reachable: Floats
    target: float | None = None

    @functools.cached_property
    def _extent(self) -> Floats:
        return np.asarray(np.ptp(self.reachable, axis=0))

    @property
    def size(self) -> float:
        """Return the longest side of the workspace, m; 1 for a point."""
        return float(self._extent.max()) or 1.0

    @property
    def flat(self) -> bool:
        """Return whether the workspace is so low that it is cut horizontally."""
        return float(self._extent[2]) < FLAT * self.size


@dataclass(frozen=True)
class _Scale:
    """What both pictures share: limits between the classes in a unit, and the factor by which
    errors are drawn larger.
    """

    limits: Sequence[float]
    unit: str
    factor: float


def arm_in_workspace(pictured: PicturedErrors) -> Iterator[Plot]:
    """Yield the arm at the poses with the largest and the smallest mean error, each in the cut
    through its workspace that holds base axis and tool.

    A cell has the mean of the 95th percentile over the poses that put the tool nearest to it; for
    fewer poses than a cell takes, none is coloured. The first plot has the scene for the viewer.
    Where all poses have one error there is one plot.
    """
    chosen = (
        {"worst": int(pictured.mean.argmax()), "best": int(pictured.mean.argmin())}
        if np.ptp(pictured.mean) > 0
        else {"shown": 0}
    )
    bias, axes = _errors(pictured, list(chosen.values()))
    longest = max(float(np.linalg.norm(each, axis=-1).max()) for each in (bias, axes))
    unit = unit_of_length(float(pictured.within.max()))
    limits = class_limits(
        *(float(each) * factor_of(unit) for each in np.percentile(pictured.within, COVERED))
    )
    scale = _Scale(limits, unit, _factor(_ERROR * pictured.size / longest) if longest else 1.0)
    shown = [
        ShownPose(
            f"{name} pose", pictured.q[k], bias[n], axes[n], _words(pictured, name, k, scale.factor)
        )
        for n, (name, k) in enumerate(chosen.items())
    ]
    scene = ArmScene(
        pictured.arm,
        shown,
        scale.factor,
        pictured.flat,
        _cells(pictured, scale) if len(pictured.q) >= NEAREST else None,
    )
    for n, (name, k) in enumerate(chosen.items()):
        yield Plot(
            f"arm-{name}" if n else "arm",
            FIRST_SCREEN,
            *_picture(pictured, name, k, bias[n], scale),
            None if n else scene,
        )


def sections_of(pictured: PicturedErrors) -> PoseValues:
    """Return the 95th percentile at each pose for sections in the classes of the pictures above,
    with the worst pose marked.
    """
    unit = unit_of_length(float(pictured.within.max()))
    values, target = (
        pictured.within * factor_of(unit),
        None if pictured.target is None else pictured.target * factor_of(unit),
    )
    return PoseValues(
        pictured.arm,
        pictured.tool,
        values,
        _WHAT,
        unit,
        int(pictured.mean.argmax()),
        "worst pose",
        pictured.reachable,
        target,
    )


def _errors(pictured: PicturedErrors, poses: Sequence[int]) -> tuple[Floats, Floats]:
    """Return the mean error vectors (pose, 3), and the semi-axes (pose, axis, 3) of the ellipsoids
    with 95 % of the positions about them, m.
    """
    matrix = pose_matrix(pictured.arm, pictured.q[poses], approach=pictured.approach)
    drawn = matrix.merged.tool[:, 3:][
        :, :, matrix.merged.columns("robot", "visit", "robot x visit")
    ]
    squares, axes = np.linalg.eigh(drawn @ drawn.transpose(0, 2, 1))
    # right-handed, or the viewer would draw its surface inside out
    axes = axes * np.linalg.det(axes)[:, None, None]
    return matrix.bias[:, 3:], _WITHIN_95 * np.sqrt(np.maximum(squares, 0.0))[
        :, :, None
    ] * axes.transpose(0, 2, 1)


def _words(pictured: PicturedErrors, name: str, pose: int, factor: float) -> str:
    """Return what the viewer shows at a pose."""
    within, mean = (length(float(each[pose])) for each in (pictured.within, pictured.mean))
    errors = (
        (
            f" Arrow: mean error; ellipsoid: 95 % of positions about it; both drawn {factor:g} "
            "times larger."
        )
        if pictured.mean[pose]
        else ""
    )
    return (
        f"{name.capitalize()} pose: mean error {mean}, 95 % of positions within {within}.{errors}"
    )


def _cells(pictured: PicturedErrors, scale: _Scale) -> Cells:
    """Return the coloured cells of the workspace."""
    edge = pictured.size / CELLS
    low, values = cells_in_space(
        pictured.reachable,
        pictured.tool,
        pictured.within * factor_of(scale.unit),
        edge,
        symmetry_axis(pictured.arm),
    )
    return Cells(edge, low, class_of(values, scale.limits), scale.limits, _WHAT, scale.unit)


def _picture(
    pictured: PicturedErrors, name: str, pose: int, bias: Floats, scale: _Scale
) -> tuple[Figure, str]:
    """Return the figure of the arm at a pose in its cut, and what it shows in words."""
    tool, edge, error = pictured.tool[pose], pictured.size / CELLS, scale.factor * bias
    view, names = _view(tool, flat=pictured.flat)
    drawn, on = one("", 132, width=178)
    shown, axis = pictured.within * factor_of(scale.unit), symmetry_axis(pictured.arm)
    across, up, values = cells_of_cut(
        pictured.reachable, pictured.tool, shown, view, float(view[2] @ tool), edge, axis
    )
    coloured = len(pictured.q) >= NEAREST
    if coloured:
        cells(on, across * 1e3, up * 1e3, class_of(values, scale.limits))
        class_legend(drawn, scale.limits, f"{_WHAT} [{scale.unit}]")
    else:
        cells(on, across * 1e3, up * 1e3, np.where(np.isfinite(values), 0, -1), (LIGHT["line"],))
    seen = np.concatenate(
        [*_arm(on, pictured, pose, view), 1e3 * np.column_stack([across[[0, -1]], up[[0, -1]]])]
    )
    on.set_xlim(float(seen[:, 0].min()) - 1e3 * edge, float(seen[:, 0].max()) + 1e3 * edge)
    on.set_ylim(float(seen[:, 1].min()) - 1e3 * edge, float(seen[:, 1].max()) + 1e3 * edge)
    arrow = ""
    if float(np.linalg.norm(view[:2] @ bias)) > _SHOWN * float(np.linalg.norm(bias)):
        start, end = (1e3 * (view[:2] @ each) for each in (tool, tool + error))
        on.annotate(
            "",
            end,
            start,
            arrowprops={
                "arrowstyle": "-|>",
                "color": LIGHT["warn"],
                "lw": 2.2,
                "mutation_scale": 14,
            },
            zorder=6,
        )
        arrow = (
            f" The arrow is the mean error vector in this plane, drawn {scale.factor:g} times "
            "larger."
        )
    on.set_aspect("equal")
    label_axes(on, *(f"{each} [mm]" for each in names))
    of_cells = (
        f"Cells: mean over the {NEAREST} nearest poses."
        if coloured
        else "Grey: what the tool reaches."
    )
    mean = length(float(pictured.mean[pose]))
    return (
        drawn,
        (
            f"The arm at {_MEANING.get(name, 'a pose')}, {mean}, in the cut through its workspace "
            f"at the tool. {of_cells}{arrow}"
        ),
    )


def _view(tool: Floats, *, flat: bool) -> tuple[Floats, tuple[str, str]]:
    """Return the directions to the right, upwards and towards the viewer (3, 3) of the cut through
    a tool point, and the names of the first two.
    """
    if flat:
        return np.eye(3), ("x", "y")
    azimuth = math.atan2(tool[1], tool[0])
    right = np.array([math.cos(azimuth), math.sin(azimuth), 0.0])
    return np.array([right, [0.0, 0.0, 1.0], np.cross(right, [0.0, 0.0, 1.0])]), (
        "distance from the base's axis",
        "z",
    )


def _arm(on: Axes, pictured: PicturedErrors, pose: int, view: Floats) -> list[Floats]:
    """Draw the bodies of the arm from far to near, and return their outlines (corner, 2), mm."""
    from matplotlib.patches import Polygon

    at = state_of(pictured.arm, pictured.q[pose : pose + 1]).frames[:, 0]
    bodies = sorted(
        pictured.arm.bodies, key=lambda body: float(view[2] @ (at[body.place] @ body.pose)[:3, 3])
    )
    outlines = [body.silhouette(at[body.place], view[:2]) * 1e3 for body in bodies]
    for body, outline in zip(bodies, outlines, strict=True):
        on.add_patch(
            Polygon(
                outline,
                facecolor=LIGHT[_FILLS.get(body.kind, "line")],
                edgecolor=LIGHT["ink"],
                linewidth=0.7,
                zorder=5,
            )
        )
    return outlines


def _factor(most: float) -> float:
    """Return the largest of 1, 2 and 5 times a power of ten that is at most this, and at least
    1.
    """
    return max(1.0, round_below(most))
