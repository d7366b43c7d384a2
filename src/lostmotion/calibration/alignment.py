"""The frame of an instrument, before any error is estimated: measured positions in the base frame,
and signs of an arm, a tool or a file that do not belong together.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, Final, NamedTuple

import numpy as np
from scipy.spatial.transform import Rotation

from lostmotion.calibration.instruments import FullPoses, Points
from lostmotion.calibration.sets import FEWEST_IN_SET, in_sets, set_in_words
from lostmotion.laws.frame_fit import rigid
from lostmotion.mechanism.state import state_of
from lostmotion.spatial import inverse

if TYPE_CHECKING:
    from collections.abc import Mapping

    from numpy.typing import NDArray

    from lostmotion.calibration.instruments import Instrument, MeasuredVisits
    from lostmotion.calibration.terms import Deviations
    from lostmotion.mechanism.arm import Arm
    from lostmotion.spatial import Floats

_STEPS: Final = 200
_SETTLED: Final = 1e-12
# Fewest positions by which a tool offset is distinguished from the frame.
_FEWEST: Final = 6
# A frame farther from the base than so many prior deviations is that of the instrument.
_FAR: Final = 3.0
# Largest share of the reach that base and tool may leave, and offset of the tool, in prior
# deviations.
_WRONG_ARM: Final = 0.05
_WRONG_TOOL: Final = 5.0
# Prior deviations from the first estimate at which an unknown of an instrument is lost.
_LOST: Final = 5.0
# Mean angle that one turn of the tool may leave of measured orientations, degrees.
_WRONG_TURN: Final = 5.0
# Share of the rows that the best frames are estimated from where others may be wrong, and distance
# from which these are: over the median of those, and an eighth of the reach.
_TRUSTED: Final = 0.75
_TRIMS: Final = 20
_WRONG_SHARE: Final = 0.125
# Fewest rows among which a wrong one is found: three quarters determine the frames.
_MANY: Final = 8
# Least r.m.s. distance of points from a line by which a turn about it is known, over the reach.
_LINE: Final = 0.01
_WRONG_ROW: Final = 20.0


class WrongArmError(ValueError):
    """A measurement that does not belong to this arm or this tool."""


class Alignment(NamedTuple):
    """A rigid motion and a tool offset that bring nominal onto measured positions.

    frame   (4, 4) base frame in the frame of the instrument, m
    offset  (3,) shift of the tool point in the tool's axes, m
    left    mean distance that remains, m
    """

    frame: Floats
    offset: Floats
    left: float

    @property
    def turn(self) -> float:
        """Return the angle of the frame, rad."""
        return float(np.arccos(np.clip((np.trace(self.frame[:3, :3]) - 1) / 2, -1.0, 1.0)))

    @property
    def shift(self) -> float:
        """Return the shift of the frame, m."""
        return float(np.linalg.norm(self.frame[:3, 3]))


def align(frames: Floats, measured: Floats, *, with_tool: bool = True) -> Alignment:
    """Return the rigid motion, and the tool offset where asked for, from nominal frames of the tool
    (pose, 4, 4) to measured positions (pose, 3), by turns.
    """
    offset = np.zeros(3)
    frame = rigid(measured, frames[:, :3, 3])
    steps = _STEPS if with_tool and len(frames) >= _FEWEST else 0
    for _ in range(steps):
        moved = frame @ frames
        wanted = np.einsum("pji,pj->pi", moved[:, :3, :3], measured - moved[:, :3, 3])
        before, offset = offset, wanted.mean(axis=0)
        frame = rigid(measured, frames[:, :3, 3] + frames[:, :3, :3] @ offset)
        if np.abs(offset - before).max() < _SETTLED:
            break
    left = _left(frames, measured, frame, offset)
    return Alignment(frame, offset, float(left.mean()))


def _left(frames: Floats, measured: Floats, frame: Floats, offset: Floats) -> Floats:
    """Return the distances (pose,) that remain, m."""
    moved = frame @ frames
    left = measured - moved[:, :3, 3] - moved[:, :3, :3] @ offset
    return np.asarray(np.linalg.norm(left, axis=1))


def plausible_rows(arm: Arm, measured: MeasuredVisits) -> NDArray[np.int64]:
    """Return the visits whose points no gross mistake moved: all of them for most measurements.

    The best frames are those of three quarters of the rows of a set-up, whose distances are least.
    Source: P. Rousseeuw, K. Van Driessen, Data Min. Knowl. Disc. 12 (2006) 29 (least trimmed
    squares).
    """
    frames = state_of(arm, measured.q).frames[-1]
    point = measured.point
    if measured.difference is not None:
        point = frames[:, :3, 3] + measured.difference
    if point is None:
        return np.arange(len(measured))
    each = [rows[_plausible(frames[rows], point[rows])] for rows in measured.by_set.values()]
    return np.sort(np.concatenate(each))


def _plausible(frames: Floats, point: Floats) -> NDArray[np.int64]:
    """Return the points (pose, 3) of one set-up that no gross mistake moved."""
    if len(point) < _MANY:
        return np.arange(len(point))
    trusted = np.arange(len(point))
    for _ in range(_TRIMS):
        found = align(frames[trusted], point[trusted])
        left = _left(frames, point, found.frame, found.offset)
        before, order = trusted, np.argsort(left, kind="stable")
        trusted = np.sort(order[: int(np.ceil(_TRUSTED * len(point)))])
        if np.array_equal(before, trusted):
            break
    reach = float(np.linalg.norm(frames[:, :3, 3], axis=1).max())
    usual = float(np.median(left[trusted]))
    return np.flatnonzero(left <= max(_WRONG_ROW * usual, _WRONG_SHARE * reach))


def in_base(frame: Floats, points: Floats) -> Floats:
    """Return positions (pose, 3) of the instrument's frame in the base frame (4, 4)."""
    back = inverse(frame)
    return np.asarray(points @ back[:3, :3].T + back[:3, 3])


def to_base(
    frames: Floats, point: Floats, rotation: Floats | None, sizes: Deviations
) -> tuple[Floats, Floats | None, Alignment | None]:
    """Return measured positions and orientations in the base frame, and the frame that was removed.

    Raises WrongArmError.
    """
    reach = float(np.linalg.norm(frames[:, :3, 3], axis=1).max())
    found, rigid = align(frames, point), align(frames, point, with_tool=False)
    if found.left > _WRONG_ARM * reach:
        raise WrongArmError(
            f"{1e3 * found.left:.3g} mm remain on average with the best base and tool frame, "
            f"{100 * found.left / reach:.2g} % of the reach: the rows belong to another arm, or "
            "the joints to other columns"
        )
    tool = float(np.linalg.norm(found.offset))
    if tool > _WRONG_TOOL * sizes.tool_shift and found.left < rigid.left / 2:
        x, y, z = 1e3 * found.offset
        raise WrongArmError(
            f"the measured tool point is at x {x:.4g}, y {y:.4g}, z {z:.4g} mm from that of the "
            "arm's file, in the axes of the tool: state the tool that was measured"
        )
    if rotation is not None:
        largest = _WRONG_TOOL * max(sizes.tool_turn, sizes.base_turn)
        _refuse_other_orientation(frames, found.frame[:3, :3].T @ rotation, largest)
    if rigid.shift <= _FAR * sizes.base_shift and rigid.turn <= _FAR * sizes.base_turn:
        return point, rotation, None
    turned = None if rotation is None else rigid.frame[:3, :3].T @ rotation
    return in_base(rigid.frame, point), turned, rigid


def instrument_in_base(
    frames: Floats, point: Floats, measured: MeasuredVisits, sizes: Deviations
) -> tuple[Instrument, dict[str, Alignment | None]]:
    """Return what measured these points (visit, 3), and the orientations of the visits where there
    are any, in the base frame; and the frame that was removed of each set-up, by its name.

    frames  (visit, 4, 4) nominal frames of the tool, m

    Raises WrongArmError, which names the set where there are several.
    """
    rotation, out = measured.rotation, dict[str, Alignment | None]()
    if len(measured.by_set) == 1:
        point, rotation, out[""] = to_base(frames, point, rotation, sizes)
    else:
        point = point.copy()
        rotation = None if rotation is None else rotation.copy()
        for name, rows in measured.by_set.items():
            turns = None if rotation is None else rotation[rows]
            try:
                _refuse_few(measured.q[rows])
                point[rows], turns, out[name] = to_base(frames[rows], point[rows], turns, sizes)
                _refuse_line(frames[rows], out[name])
            except WrongArmError as error:
                raise WrongArmError(f"{set_in_words(name)}: {error}") from None
            if rotation is not None:
                rotation[rows] = turns
    seen: Instrument = Points(point)
    if rotation is not None:
        poses = np.tile(np.eye(4), (len(point), 1, 1))
        poses[:, :3, :3], poses[:, :3, 3] = rotation, point
        seen = FullPoses(poses)
    return in_sets(seen, measured, sizes), out


def _refuse_few(q: Floats) -> None:
    """Raise WrongArmError where the poses (visit, joint) are too few for the frame of a set."""
    poses = len(np.unique(q, axis=0))
    if poses < FEWEST_IN_SET:
        raise WrongArmError(f"{poses} poses do not determine its frame: measure {FEWEST_IN_SET}")


def _refuse_line(frames: Floats, alignment: Alignment | None) -> None:
    """Raise WrongArmError where a frame was removed by points on a line, about which it may have
    any turn.
    """
    points = frames[:, :3, 3]
    beside = np.linalg.svd(points - points.mean(axis=0), compute_uv=False)[1] / len(points) ** 0.5
    if alignment is not None and beside < _LINE * np.linalg.norm(points, axis=1).max():
        raise WrongArmError(
            f"its points are {1e3 * beside:.3g} mm r.m.s. from a line, about which its frame may "
            "have any turn: measure poses beside that line"
        )


def alignments_in_words(
    alignments: Mapping[str, Alignment | None], visits: MeasuredVisits
) -> list[str]:
    """Return which frames of the instrument were removed, in whose base frame the results of
    several sets are, and which sets have no pose beside those that their frame needs.

    alignments  as of `instrument_in_base`
    visits      the first one to each pose that was used
    """
    out, several = [], len(alignments) > 1
    if several:
        out.append(
            f"{len(alignments)} sets, each with a frame of its own: corrected commands are in the "
            f"base frame of {set_in_words(next(iter(alignments)))}"
        )
    for name, found in alignments.items():
        if found is not None:
            whose = f" of {set_in_words(name)}" if several else ""
            out.append(
                f"the measurements{whose} are in the frame of the instrument, "
                f"{found.shift:.3f} m and {np.degrees(found.turn):.3g}° from the base: "
                "brought into the base frame"
            )
        poses = len(visits.by_set.get(name, ()))
        if several and poses <= FEWEST_IN_SET:
            out.append(
                f"{set_in_words(name)} has {poses} poses, which its frame needs: their errors "
                "where they are held out are mostly those of that frame"
            )
    return out


def refuse_other_arm(error: Floats, frames: Floats, *, turns: bool) -> None:
    """Raise WrongArmError where readings of one number, or pixels, are far from those of any base
    and tool frame.

    error   (pose,) what these leave of each, m; with `turns` rad
    frames  (pose, 4, 4) nominal frames of the tool, m
    """
    left = float(np.median(error))
    reach = float(np.linalg.norm(frames[:, :3, 3], axis=1).max())
    if turns and np.degrees(left) > _WRONG_TURN:
        raise WrongArmError(
            f"{np.degrees(left):.3g}° remain at half the rows with the best base and tool frame: "
            "the rows belong to another arm, or the readings to other axes"
        )
    if not turns and left > _WRONG_ARM * reach:
        raise WrongArmError(
            f"{1e3 * left:.3g} mm remain at half the rows with the best base and tool frame, "
            f"{100 * left / reach:.2g} % of the reach: the rows belong to another arm, or the "
            "readings to other targets"
        )


def refuse_lost_instrument(instrument: Instrument, estimates: Floats) -> None:
    """Raise WrongArmError where an unknown of the instrument is far from its first estimate.

    estimates  (unknown,) in prior deviations
    """
    k = int(np.argmax(np.abs(estimates))) if len(estimates) else -1
    if k < 0 or abs(estimates[k]) <= _LOST:
        return
    size, unit = instrument.size(k)
    value = size * float(estimates[k])
    moved = f"{np.degrees(value):.3g}°" if unit == "rad" else f"{1e3 * value:.4g} mm"
    raise WrongArmError(
        f"the estimate of {instrument.unknowns[k]} is {moved} from where it starts, "
        f"{abs(estimates[k]):.2g} prior deviations (at most {_LOST:g} are credible): check the "
        "unit and the zero of its column, or measure more poses, of other orientations, from nearer"
    )


def _refuse_other_orientation(frames: Floats, rotation: Floats, largest: float) -> None:
    """Raise WrongArmError where orientations (pose, 3, 3) in the base are not those of the frames
    (pose, 4, 4) but for one turn of the tool, or where that exceeds `largest`, rad.
    """
    turned = frames[:, :3, :3].transpose(0, 2, 1) @ rotation
    tool = Rotation.from_matrix(turned).mean()
    left = float(np.degrees((tool.inv() * Rotation.from_matrix(turned)).magnitude().mean()))
    if left > _WRONG_TURN:
        raise WrongArmError(
            f"the measured orientations are {left:.3g}° on average from those of the arm with the "
            "best tool: rotations of another order or about other axes, or another arm"
        )
    if tool.magnitude() > largest:
        x, y, z = tool.as_euler("xyz", degrees=True)
        raise WrongArmError(
            f"the measured orientation is turned by rx {x:.3g}, ry {y:.3g}, rz {z:.3g}° from that "
            "of the arm's tool, about its axes: state the orientation of the tool that was measured"
        )
