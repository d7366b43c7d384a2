"""Plays that a load closes in some robots and leaves open in others, because friction differs from
robot to robot.

Let b be 1 in a robot whose play is closed and 0 in any other, and c the share of robots with b = 1.
An error that exists only where the play is closed is b x its screw. With z = (b - c) / sqrt(c (1 -
c)), which has mean 0 and mean square 1 at every pose, b = c + z sqrt(c (1 - c)). First and second
moments therefore remain sums over columns. Between two poses, the z of one robot has the
correlation
(min(c, c') - c c') / sqrt(c (1 - c) c' (1 - c')).
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from lostmotion.error_model.draws import Stream
    from lostmotion.spatial import Floats


@dataclass(frozen=True, slots=True)
class Closing:
    """Decides in each robot whether a load closes a play: it does where the robot's draw is at most
    the share of robots with a closed play.

    stream  one uniform per robot, compared with the share
    row     row of `PoseMatrix.closed` that holds the share at each pose
    above   True for a column that exists where the play is closed, False where it is open
    """

    stream: Stream
    row: int
    above: bool


def closed_in_some(closed: Floats) -> NDArray[np.bool_]:
    """Return whether the share of robots with a closed play (any shape) is neither 0 nor 1."""
    return (closed > 0) & (closed < 1)


def mean_and_change(closed: Floats, *, above: bool) -> tuple[Floats, Floats]:
    """Return two factors (pose,) on a screw that exists only where a play is closed (`above`), or
    only where it is open (not `above`).

    The first factor is the mean over robots, the second the change per unit of `standardised`.

    closed  (pose,) share of robots in which the play is closed, 0..1
    """
    changed = np.sqrt(closed * (1 - closed))
    return (closed, changed) if above else (1 - closed, -changed)


def third_and_fourth_moment(closed: Floats) -> Floats:
    """Return the third and fourth moments of `standardised` (2, ...), for shares of any shape;
    zeros where the share is 0 or 1.
    """
    differs = closed_in_some(closed)
    c = np.where(differs, closed, 0.5)
    return np.stack([(1 - 2 * c) / np.sqrt(c * (1 - c)), 1 / (c * (1 - c)) - 3]) * differs


def standardised(u: Floats | float, closed: Floats) -> Floats:
    """Return (b - c) / sqrt(c (1 - c)), a draw of mean 0 and mean square 1: b is 1 where a play is
    closed (u at most c) and 0 where it is open.

    u       uniforms in 0..1, of a shape that broadcasts with `closed`
    closed  c, the share of robots in which the play is closed; where it is 0 or 1 all robots are
            equal, and the draw is 0
    """
    differs = closed_in_some(closed)
    c = np.where(differs, closed, 0.5)
    return np.asarray(np.where(u <= closed, np.sqrt((1 - c) / c), -np.sqrt(c / (1 - c))) * differs)
