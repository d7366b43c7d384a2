"""Corners of tags on the tool, seen by a camera that stands still: pixels, with unknown places of
the camera and of the tags.

Depth is seen ten times worse than position across the optical axis, so corners are measurements,
and never the pose that they lead to: the image of a tag of few pixels determines no tilt. Sources:
R. Hartley, A. Zisserman, Multiple View Geometry, 2004, sections 6.3 (weak perspective) and 7.1
(linear equations of images); B. Triggs et al., Vision Algorithms, 2000, 298 (bundle adjustment).
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, ClassVar, Final

import numpy as np

from lostmotion.calibration.alignment import align
from lostmotion.calibration.instruments import Camera, Instrument, Rows
from lostmotion.spatial import exp, inverse, nearest_rotation

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from lostmotion.calibration.instruments import Readings
    from lostmotion.spatial import Floats

# Corners of a tag of edge 1 in its own plane, in the order in which detectors list them: from the
# lower left one counter-clockwise, as the tag is seen.
CORNERS: Final = np.array([[-0.5, -0.5, 0], [0.5, -0.5, 0], [0.5, 0.5, 0], [-0.5, 0.5, 0]])
# Prior deviations of the places of camera and tags, rad and m, about their first estimates.
_WIDE: Final = np.repeat([0.1, 0.1], 3)
_STEP: Final = 1e-5
# Most steps of the least squares over all corners; five are usual.
_MOST_STEPS: Final = 200


@dataclass(frozen=True, eq=False)
class Tags(Instrument):
    """Pixels of the corners of tags, u and v of each: a row is a distance at the mean distance of
    the tags, m.

    names    of the tags
    target   (pose,) number of the tag of each pose
    pixel    (pose, 4, 2) u and v of each corner
    camera   what the camera is
    at, on   (4, 4) first estimate of the camera in the base, and (tag, 4, 4) of the tags on the
             tool
    distance  mean distance of the tags from the camera, m
    """

    points: ClassVar[int] = len(CORNERS)
    names: tuple[str, ...]
    target: NDArray[np.int64]
    pixel: Floats
    camera: Camera
    at: Floats
    on: Floats
    distance: float

    @property
    def noise(self) -> Floats:
        """Return one for u and v of each corner."""
        return np.ones(2 * len(CORNERS))

    @property
    def unknowns(self) -> tuple[str, ...]:  # type: ignore[override]
        """Return turns and shifts of the camera and of each tag."""
        ways = [f"{kind} {axis}" for kind in ("turn", "shift") for axis in "xyz"]
        return tuple(f"{name} {way}" for name in ("camera", *self.names) for way in ways)

    def size(self, unknown: int) -> tuple[float, str]:
        """Return the deviation of an unknown with its unit."""
        return float(_WIDE[unknown % 6]), "rad" if unknown % 6 < 3 else "m"  # noqa: PLR2004

    def part(self, rows: NDArray[np.int64]) -> Tags:
        """Return the measurement at the poses in these rows."""
        return replace(self, target=self.target[rows], pixel=self.pixel[rows])

    def rows(self, frames: Floats, unknowns: Floats) -> Rows:
        """Return the rows: u and v of each corner. Derivatives by the unknowns are central
        differences.
        """
        predicted, by_point, beside = self._seen(frames, unknowns)
        skew = np.zeros((*beside.shape, 3))
        for k, (i, j) in enumerate(((1, 2), (2, 0), (0, 1))):
            skew[..., i, j], skew[..., j, i] = -beside[..., k], beside[..., k]
        by_twist = np.concatenate([-by_point @ skew, by_point], axis=-1)
        by_unknown = np.empty((*predicted.shape, len(unknowns)))
        for k in range(len(unknowns)):
            ends = []
            for sign in (1.0, -1.0):
                moved = unknowns.copy()
                moved[k] += sign * _STEP
                ends.append(self._seen(frames, moved)[0])
            by_unknown[..., k] = (ends[0] - ends[1]) / (2 * _STEP)
        count = len(frames)
        return Rows(
            (self.pixel * self._scale - predicted).reshape(count, -1),
            by_twist.reshape(count, -1, 6),
            by_unknown.reshape(count, -1, len(unknowns)),
        )

    @property
    def _scale(self) -> Floats:
        return self.distance / np.array(self.camera[:2])

    def _seen(self, frames: Floats, unknowns: Floats) -> tuple[Floats, Floats, Floats]:
        """Return the predicted rows (pose, 4, 2), their derivative by the corner's place in the
        base (pose, 4, 2, 3), and that place from the tool point (pose, 4, 3).
        """
        twists = unknowns.reshape(-1, 6) * _WIDE
        back = inverse(self.at @ exp(twists[0]))
        tags = frames @ (self.on @ exp(twists[1:]))[self.target]
        corners = self.camera.size * CORNERS
        places = corners @ tags[:, :3, :3].transpose(0, 2, 1) + tags[:, None, :3, 3]
        x, y, z = np.moveaxis(places @ back[:3, :3].T + back[:3, 3], -1, 0)
        f, c = np.array(self.camera[:2]), np.array(self.camera[2:4])
        none = np.zeros_like(z)
        by_u, by_v = np.array([1 / z, none, -x / z**2]), np.array([none, 1 / z, -y / z**2])
        by = np.moveaxis(np.array([by_u, by_v]), (0, 1), (-2, -1))
        by_point = (f * self._scale)[:, None] * by @ back[:3, :3]
        pixel = np.stack([x / z, y / z], axis=-1) * f + c
        return pixel * self._scale, by_point, places - frames[:, None, :3, 3]


def tags_of(readings: Readings, frames: Floats) -> Tags:
    """Return the instrument of these pixels; places of camera and tags are first estimated by least
    squares over all corners at nominal frames of the tool (pose, 4, 4).
    """
    assert readings.camera is not None  # noqa: S101 - refused where a file is read
    camera, names = readings.camera, tuple(dict.fromkeys(readings.target))
    target = np.array([names.index(name) for name in readings.target])
    seen = (readings.value - np.array(camera[2:4])) / np.array(camera[:2])
    depth = _depth(seen, camera.size)
    middle = np.concatenate([seen.mean(axis=1), np.ones((len(seen), 1))], axis=1)
    first = target == int(np.argmax(np.bincount(target)))
    back = align(frames[first], (depth[:, None] * middle)[first]).frame
    tools = back @ frames
    on = [
        _on_tool(tools[own], seen[own], camera.size)
        for own in target == np.arange(len(names))[:, None]
    ]
    start = Tags(names, target, readings.value, camera, inverse(back), np.array(on), depth.mean())
    return _refined(start, frames)


def _depth(seen: Floats, size: float) -> Floats:
    """Return the distances (pose,) along the optical axis of tags of an edge, m, by their corners
    (pose, 4, 2) at a distance of one.

    The longest image of a unit length in the tag is one over the distance at any tilt.
    """
    by_place = np.linalg.pinv(size * CORNERS[:, :2]) @ (seen - seen.mean(axis=1, keepdims=True))
    return np.asarray(1 / np.linalg.norm(by_place, 2, axis=(1, 2)))


def _on_tool(tools: Floats, seen: Floats, size: float) -> Floats:
    """Return the frame (4, 4) of a tag on the tool by its corners (pose, 4, 2) at a distance of
    one, for tools in the frame of the camera (pose, 4, 4): linear in its place and two axes.
    """
    across = np.concatenate([np.tile(-np.eye(2), (*seen.shape[:2], 1, 1)), seen[..., None]], axis=3)
    by_place = across @ tools[:, None, :3, :3]
    columns = np.concatenate(
        [by_place * weight for weight in (1.0, *(size * CORNERS.T[:2, None, :, None, None]))],
        axis=3,
    )
    offset = across @ tools[:, None, :3, 3:]
    place, x, y = np.linalg.lstsq(columns.reshape(-1, 9), -offset.ravel())[0].reshape(3, 3)
    out = np.eye(4)
    out[:3, :3] = nearest_rotation(np.column_stack([x, y, np.cross(x, y)]))
    out[:3, 3] = place
    return out


def _refined(tags: Tags, frames: Floats) -> Tags:
    """Return the tags with the places of least squares over all corners."""
    from scipy.optimize import least_squares

    def residual(unknowns: Floats) -> Floats:
        return tags.rows(frames, unknowns).residual.ravel()

    def slope(unknowns: Floats) -> Floats:
        by_unknown = tags.rows(frames, unknowns).by_unknown
        return -by_unknown.reshape(-1, len(unknowns))

    start = np.zeros(len(tags.unknowns))
    found = least_squares(residual, start, slope, method="lm", max_nfev=_MOST_STEPS)
    twists = exp(found.x.reshape(-1, 6) * _WIDE)
    at, on = tags.at @ twists[0], tags.on @ twists[1:]
    distance = (inverse(at) @ frames @ on[tags.target])[:, 2, 3].mean()
    return replace(tags, at=at, on=on, distance=abs(float(distance)))
