"""Corners of tags on the tool, seen by a camera that stands still: pixels, with unknown places of
the camera and of the tags.

Depth is seen ten times worse than position across the optical axis, so corners are measurements,
and never the pose that they lead to. Sources: R. Hartley, A. Zisserman, Multiple View Geometry,
2004, section 4.1 (homography); A. Li, L. Wang, D. Wu, Int. J. Physical Sciences 5 (2010) 1530
(camera and tag from poses of both, by Kronecker products).
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, ClassVar, Final

import numpy as np

from lostmotion.calibration.instruments import Camera, Instrument, Rows
from lostmotion.spatial import exp, inverse, mean_pose, nearest_rotation

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
    """Return the instrument of these pixels; places of camera and tags are first estimated at
    nominal frames of the tool (pose, 4, 4).
    """
    assert readings.camera is not None  # noqa: S101 - refused where a file is read
    camera, names = readings.camera, tuple(dict.fromkeys(readings.target))
    target = np.array([names.index(name) for name in readings.target])
    seen = np.array([_pose(each, camera) for each in readings.value])
    first = int(np.argmax(np.bincount(target)))
    at = _camera_in_base(frames[target == first], seen[target == first])
    on = [mean_pose((inverse(frames) @ at @ seen)[target == k]) for k in range(len(names))]
    distance = float(seen[:, 2, 3].mean())
    return Tags(names, target, readings.value, camera, at, np.array(on), distance)


def _pose(pixels: Floats, camera: Camera) -> Floats:
    """Return the frame (4, 4) of a tag in the camera from its four corners (4, 2), px."""
    seen = (pixels - np.array(camera[2:4])) / np.array(camera[:2])
    rows = []
    for (x, y, _), (u, v) in zip(CORNERS * camera.size, seen, strict=True):
        rows += [[x, y, 1, 0, 0, 0, -u * x, -u * y, -u], [0, 0, 0, x, y, 1, -v * x, -v * y, -v]]
    h = np.linalg.svd(np.array(rows))[2][-1].reshape(3, 3)
    h *= np.sign(h[2, 2]) / np.sqrt(np.linalg.norm(h[:, 0]) * np.linalg.norm(h[:, 1]))
    out = np.eye(4)
    out[:3, :3] = nearest_rotation(np.column_stack([h[:, 0], h[:, 1], np.cross(h[:, 0], h[:, 1])]))
    out[:3, 3] = h[:, 2]
    return out


def _camera_in_base(tools: Floats, tags: Floats) -> Floats:
    """Return the camera C (4, 4) in the base from tools T and tags B in the camera (pose, 4, 4):
    T X = C B with an unknown X.
    """
    eye = np.eye(3)
    rows = [
        np.hstack([np.kron(t[:3, :3], eye), -np.kron(eye, b[:3, :3].T)])
        for t, b in zip(tools, tags, strict=True)
    ]
    found = np.linalg.svd(np.concatenate(rows), full_matrices=False)[2][-1].reshape(2, 3, 3)
    out = np.eye(4)
    out[:3, :3] = nearest_rotation(found[1] * np.sign(np.linalg.det(found[1])))
    left = np.concatenate([np.hstack([t[:3, :3], -eye]) for t in tools])
    right = np.concatenate(
        [out[:3, :3] @ b[:3, 3] - t[:3, 3] for t, b in zip(tools, tags, strict=True)]
    )
    out[:3, 3] = np.linalg.lstsq(left, right, rcond=None)[0][3:]
    return out
