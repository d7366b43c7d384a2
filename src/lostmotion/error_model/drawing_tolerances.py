"""Tolerances as drawings state them, checked on the errors of the tool at the places of a task.

Every tolerance is a linear map of the errors of all places, followed by a norm: across the axis of
a cylinder, along the axes of a box, after a frame or a reference line was fitted. So its mean
square follows without sampling, and samples need one matrix product; they turn a fitted frame back
to second order. Errors are small: rotation vector and displacement of the tool point, base axes.
Lines, circles and planes are least-squares references (ISO 12780-1, 12181-1, 12781-1), whose
deviation is never below that of the minimum zone.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Final, Literal, TypeAlias, get_args

import numpy as np

from lostmotion.error_model.datum_frames import (
    carried_by,
    datum_motion,
    fitted_motion,
    seen_from,
    size_of,
)
from lostmotion.spatial import skew

if TYPE_CHECKING:
    from collections.abc import Sequence

    from numpy.typing import NDArray

    from lostmotion.spatial import Floats

Kind: TypeAlias = Literal[
    "box",
    "cylinder",
    "sphere",
    "orientation",
    "distance",
    "straightness",
    "roundness",
    "flatness",
]
KINDS: Final[tuple[str, ...]] = get_args(Kind)
# Fewest places of a form: one more than its reference has parameters per place.
FEWEST: Final = {"straightness": 3, "roundness": 4, "flatness": 4}
# Nominal places may be off their line, circle or plane by this share of their extent.
_OFF: Final = 1e-6
# m; features that are nearer are at one place.
_NOTHING: Final = 1e-9


@dataclass(frozen=True)
class Feature:
    """TaskPlaces of a task that belong together.

    places   numbers of its places, in the order of the visits
    kind     "point", "holes", "line", "circle", "plane" or "path"
    axis     (3,) normal of a plane, circle or hole pattern, direction of a line, base axes; None
             where it has none
    """

    name: str
    kind: str
    places: NDArray[np.int64]
    axis: Floats | None

    @property
    def fixed_ways(self) -> Floats:
        """Return the directions (n, 3) that a datum feature fixes: the normal of a plane, across a
        line, and all of other features.
        """
        if self.kind == "plane" and self.axis is not None:
            return np.asarray(self.axis[None])
        if self.kind == "line" and self.axis is not None:
            return np.asarray(np.linalg.svd(self.axis[None])[2][1:])
        return np.eye(3)


@dataclass(frozen=True)
class DrawingTolerance:
    """A tolerance as stated.

    kind         what must lie within
    size         full widths of a box along the axes of the task, diameter of a cylinder or sphere,
                 width of a zone of form, largest deviation (±) of a distance, m; largest angle, rad
    features     numbers of the features that it applies to
    datum        "base"; "fitted": a frame fitted over all places; or numbers of datum features, in
                 their order of precedence
    axis         "tool", "path", "x", "y" or "z" (of the task): axis of a cylinder, or axis whose
                 tilt counts; "": that of the feature, or any tilt
    length       length of the axis that lies within a cylinder, from the tool point back along the
                 tool's z, m: that of a peg in its hole
    where        file and key, for messages
    """

    name: str
    kind: Kind
    size: tuple[float, ...]
    features: tuple[int, ...]
    datum: Literal["base", "fitted"] | tuple[int, ...] = "base"
    axis: str = ""
    length: float = 0.0
    where: tuple[str, str] = ("", "")


class TaskGeometryError(ValueError):
    """A tolerance that the places of the task cannot have: what was found, what is expected."""

    def __init__(self, tolerance: DrawingTolerance, found: str, expected: str) -> None:
        """Keep the parts of the message."""
        super().__init__(f"{found}; expected {expected}")
        self.tolerance, self.found, self.expected = tolerance, found, expected


@dataclass(frozen=True)
class TaskPlaces:
    """The places of a task where tolerances apply, in the base's frame.

    frames    (place, 4, 4) commanded poses of the tool, m
    along     (place, 3) unit direction of travel, zero where unknown
    axes      (3, 3) axes of the task, columns, in the base's axes
    """

    frames: Floats
    along: Floats
    axes: Floats

    @property
    def points(self) -> Floats:
        """Return the commanded points (place, 3), m."""
        return np.asarray(self.frames[:, :3, 3])


@dataclass(frozen=True, eq=False)
class ToleranceCheck:
    """How a tolerance is checked on errors of all places (place, 6, sample).

    places   (p,) the places that it reads
    rows     (p, c, 6) components of an error, as shares of the limit
    weights  (p,) of a difference of means over the places; None where each place counts by itself
    shapes   (p, parameter) orthonormal shapes of the reference that is fitted; None without one
    motion   (6, place, 6) motion of the fitted or datum frame per error; None: the base
    about    (place, 3) points from their middle, about which that frame moves, m
    norm     "largest" component, "length" of all, "spread" between places, or "distance"
    span     (3,) nominal distance vector, as a share of the limit
    """

    tolerance: DrawingTolerance
    places: NDArray[np.int64]
    rows: Floats
    weights: Floats | None
    shapes: Floats | None
    motion: Floats | None
    about: Floats
    norm: Literal["largest", "length", "spread", "distance"]
    span: Floats

    @property
    def outputs(self) -> NDArray[np.int64]:
        """Return the place of each output (o,); of a distance, the first of its places."""
        return self.places[:1] if self.norm == "distance" else self.places

    @property
    def rigid(self) -> Floats:
        """Return the errors (p, 6, 6) of places that move with the frame."""
        return carried_by(self.about[self.places])

    def components(self, errors: Floats) -> Floats:
        """Return the components (o, c, sample), as shares of the limit."""
        found = self.rows @ errors[self.places]
        if self.motion is not None:
            moved = np.tensordot(self.motion, errors, axes=2)
            found = found - (self.rows @ self.rigid) @ moved
        if self.shapes is not None:
            found = found - np.tensordot(
                self.shapes, np.tensordot(self.shapes.T, found, axes=1), axes=1
            )
        return found if self.weights is None else np.tensordot(self.weights, found, axes=1)[None]

    def used(self, errors: Floats) -> tuple[Floats, Floats]:
        """Return the share of the tolerance that is used: (sample,) as a whole, and (o, sample) by
        place. The tolerance holds where it is at most one.
        """
        if self.motion is not None:
            errors = seen_from(self.motion, self.about, errors)
        found = self.components(errors)
        if self.norm == "distance":
            span = self.span[:, None]
            by = np.abs(np.linalg.norm(span + found[0], axis=0) - np.linalg.norm(span))[None]
        elif self.norm == "largest":
            by = np.abs(found).max(axis=1)
        elif self.norm == "spread":
            one = found[:, 0]
            return one.max(axis=0) - one.min(axis=0), 2 * np.abs(one)
        else:
            by = np.sqrt((found**2).sum(axis=1))
        return by.max(axis=0), by

    def operator(self, output: int, count: int) -> Floats:
        """Return the components of one output as a linear map (c, place, 6) of the errors of all
        `count` places. A distance has one component, along its nominal direction.
        """
        weight = np.zeros(len(self.places))
        weight[output] = 1.0
        if self.weights is not None:
            weight = self.weights
        elif self.shapes is not None:
            weight -= self.shapes @ self.shapes[output]
        out = np.zeros((self.rows.shape[1], count, 6))
        for place, own, by in zip(self.places, self.rows, weight, strict=True):
            out[:, place] += by * own
        if self.motion is not None:
            turned = np.tensordot(weight, self.rows @ self.rigid, axes=1)
            out -= np.tensordot(turned, self.motion, axes=1)
        if self.norm == "distance":
            along = self.span / max(float(np.linalg.norm(self.span)), 1e-300)
            out = np.tensordot(along, out, axes=1)[None]
        return out


def measure(
    stated: DrawingTolerance, features: Sequence[Feature], places: TaskPlaces
) -> ToleranceCheck:
    """Return how a tolerance of these features is checked.

    Raises TaskGeometryError for a form whose nominal places lie on no common line, circle or plane,
    a distance that does not join two features, and datum features that do not fix their frame.
    """
    chosen = [features[k] for k in stated.features]
    at = np.concatenate([each.places for each in chosen])
    weights, shapes, span, norm = None, None, np.zeros(3), "length"
    if stated.kind == "box":
        rows = _displaced(2 / np.array(stated.size)[:, None] * places.axes.T, len(at))
        norm = "largest"
    elif stated.kind == "sphere":
        rows = _displaced(2 / stated.size[0] * np.eye(3), len(at))
    elif stated.kind == "cylinder":
        across = 2 / stated.size[0] * _across(_axes(stated, chosen, places))
        rows = _displaced(across)
        if stated.length:
            lever = -stated.length * places.frames[at, :3, 2]
            far = rows.copy()
            far[..., :3] = -across @ skew(lever)
            at, rows = np.concatenate([at, at]), np.concatenate([rows, far])
    elif stated.kind == "orientation":
        turned = _across(_axes(stated, chosen, places)) if stated.axis else np.eye(3)
        rows = np.zeros((len(at), 3, 6))
        rows[..., :3] = turned / stated.size[0]
    elif stated.kind == "distance":
        if len(chosen) != 2:  # noqa: PLR2004 - from one to another
            raise TaskGeometryError(stated, f"{len(chosen)} features", "two, from one to the other")
        rows = _displaced(np.eye(3) / stated.size[0], len(at))
        first, last = chosen
        counts = len(first.places), len(last.places)
        weights = np.repeat([-1 / counts[0], 1 / counts[1]], counts)
        span, norm = weights @ places.points[at] / stated.size[0], "distance"
        if not np.linalg.norm(span) * stated.size[0] > _NOTHING:
            raise TaskGeometryError(stated, "features at one place", "a distance between them")
    else:
        rows, shapes = _form(stated, places.points[at])
        norm = "length" if stated.kind == "straightness" else "spread"
    about = places.points - places.points.mean(axis=0)
    motion = None if stated.datum == "base" else _motion(stated, features, about)
    found = ToleranceCheck(stated, at, rows, weights, shapes, motion, about, norm, span)  # type: ignore[arg-type]
    _refuse_own_datum(found)
    if isinstance(stated.datum, tuple):
        _refuse_loose(found, features)
    return found


def _displaced(rows: Floats, count: int = 0) -> Floats:
    """Return rows that read displacements (p, c, 6), from (c, 3) for all or (p, c, 3) for each."""
    out = np.zeros((count or len(rows), rows.shape[-2], 6))
    out[..., 3:] = rows
    return out


def _across(axes: Floats) -> Floats:
    """Return the projections (p, 3, 3) across unit axes (p, 3)."""
    return np.asarray(np.eye(3) - axes[:, :, None] * axes[:, None, :])


def _axes(stated: DrawingTolerance, chosen: Sequence[Feature], places: TaskPlaces) -> Floats:
    """Return the axis (p, 3) of the tolerance at each of its places."""
    out = []
    for each in chosen:
        name = stated.axis or {"line": "path", "path": "path", "circle": "path"}.get(each.kind, "")
        if name == "path":
            along = places.along[each.places]
            if not along.any(axis=1).all():
                raise TaskGeometryError(
                    stated, f"no direction of travel at '{each.name}'", "an axis: tool, x, y or z"
                )
            out.append(along)
        elif name in {"x", "y", "z"}:
            out.append(np.tile(places.axes[:, "xyz".index(name)], (len(each.places), 1)))
        elif name == "" and each.axis is not None:
            out.append(np.tile(each.axis, (len(each.places), 1)))
        else:
            out.append(places.frames[each.places, :3, 2])
    return np.concatenate(out)


def _form(stated: DrawingTolerance, points: Floats) -> tuple[Floats, Floats]:
    """Return the rows (p, c, 6) and the shapes of the reference of a zone of form, from the nominal
    points.
    """
    count = len(points)
    if count < FEWEST[stated.kind]:
        raise TaskGeometryError(
            stated,
            "a single place" if count == 1 else f"{count} places",
            f"at least {FEWEST[stated.kind]}, more than fix the reference",
        )
    off = points - points.mean(axis=0)
    size = float(np.abs(off).max())
    _, values, (first, second, normal) = np.linalg.svd(off, full_matrices=False)
    if stated.kind == "straightness":
        if values[1] > _OFF * values[0] or size < _NOTHING:
            raise TaskGeometryError(stated, "places that lie on no line", "a straight feature")
        rows = 2 / stated.size[0] * np.stack([second, normal])
        return _displaced(rows, count), _orthonormal(
            np.column_stack([np.ones(count), off @ first / size])
        )
    if values[2] > _OFF * values[0] or values[1] <= _OFF * values[0]:
        raise TaskGeometryError(stated, "places that span no plane", "a plane feature or a circle")
    x, y = off @ first, off @ second
    if stated.kind == "flatness":
        rows = normal[None] / stated.size[0]
        return _displaced(rows, count), _orthonormal(
            np.column_stack([np.ones(count), x / size, y / size])
        )
    # Circle through the points: x^2 + y^2 = 2 a x + 2 b y + c
    a, b, _ = np.linalg.lstsq(np.column_stack([2 * x, 2 * y, np.ones(count)]), x**2 + y**2)[0]
    radii = np.hypot(x - a, y - b)
    if np.ptp(radii) > _OFF * size:
        raise TaskGeometryError(stated, "places that lie on no circle", "a circle")
    cos, sin = (x - a) / radii, (y - b) / radii
    outward = cos[:, None] * first + sin[:, None] * second
    return (
        _displaced(outward[:, None] / stated.size[0]),
        _orthonormal(np.column_stack([np.ones(count), cos, sin])),
    )


def _orthonormal(shapes: Floats) -> Floats:
    """Return orthonormal shapes (p, parameter) with the span of these."""
    return np.asarray(np.linalg.qr(shapes)[0])


def _motion(stated: DrawingTolerance, features: Sequence[Feature], about: Floats) -> Floats:
    """Return the motion (6, place, 6) of the frame that a tolerance is relative to."""
    if stated.datum == "fitted":
        return fitted_motion(about)
    datum = [features[k] for k in stated.datum if isinstance(k, int)]
    return datum_motion(about, [(each.places, each.fixed_ways) for each in datum])


def _refuse_own_datum(checked: ToleranceCheck) -> None:
    """Raise TaskGeometryError where the frame follows all that the tolerance reads: it always
    holds.
    """
    if checked.motion is None:
        return
    errors = np.random.default_rng(0).standard_normal((len(checked.about), 6, 4))
    errors[:, :3] /= size_of(checked.about)
    before = np.abs(checked.rows @ errors[checked.places]).max()
    if np.abs(checked.components(errors)).max() < _OFF * before:
        raise TaskGeometryError(
            checked.tolerance,
            "a tolerance relative to itself: the frame follows its places",
            "datum features of other places, or the base",
        )


def _refuse_loose(checked: ToleranceCheck, features: Sequence[Feature]) -> None:
    """Raise TaskGeometryError where the datum features leave a motion free that the tolerance
    reads.
    """
    moved = carried_by(checked.about)
    moved[:, :, :3] /= size_of(checked.about)  # of unit displacement at the size of the task
    before = np.abs(checked.rows @ moved[checked.places]).max()
    if np.abs(checked.components(moved)).max(initial=0.0) > 1e-6 * before:
        names = ", ".join(
            f"'{features[k].name}'" for k in checked.tolerance.datum if isinstance(k, int)
        )
        raise TaskGeometryError(
            checked.tolerance,
            f"datum features {names} that leave a motion of their frame free",
            "datum features that fix it: a plane, a line in it and a point, or three places",
        )
