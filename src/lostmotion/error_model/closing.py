"""Plays that a load closes in some robots and leaves open in others, because friction differs from robot to robot.

With b = 1 in a robot whose play is closed and c the share of such robots, an error that is there only where the play is closed is b x its screw: on
average c times, and z sqrt(c (1 - c)) beyond that, where z = (b - c) / sqrt(c (1 - c)) has mean 0 and mean square 1 at every pose. First and second
moments so remain sums over columns. Between two poses z of one robot has the correlation (min(c, c') - c c') / sqrt(c (1 - c) c' (1 - c')).
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

if TYPE_CHECKING:
    from lostmotion.error_model.draws import Stream
    from lostmotion.spatial import Floats


@dataclass(frozen=True, slots=True)
class Closing:
    """What decides in each robot whether a load closes a play: one uniform of `stream` per robot, at most the share `closed[row]` of the pose matrix.

    above  whether the column is there where the play is closed, or else where it is open
    """

    stream: Stream
    row: int
    above: bool


def mean_and_change(closed: Floats, *, above: bool) -> tuple[Floats, Floats]:
    """Return the factors (pose,) on a screw that is there only where a play is closed (`above`), or only where it is open.

    The first is its mean over robots, the second its change per unit of `standardised`: closed (pose,) is the share of robots with a closed play.
    """
    changed = np.sqrt(closed * (1 - closed))
    return (closed, changed) if above else (1 - closed, -changed)


def third_and_fourth_moment(closed: Floats) -> Floats:
    """Return the mean third and fourth power of `standardised` (2, ...), by shares of any shape; zeros where all robots are the same."""
    differs = (closed > 0) & (closed < 1)
    c = np.where(differs, closed, 0.5)
    return np.stack([(1 - 2 * c) / np.sqrt(c * (1 - c)), 1 / (c * (1 - c)) - 3]) * differs


def standardised(u: Floats | float, closed: Floats) -> Floats:
    """Return whether plays are closed, as a draw of mean 0 and mean square 1: (b - c) / sqrt(c (1 - c)), b being 1 where u is at most c, and else 0.

    u      uniforms in 0..1, of a shape that broadcasts with
    closed share of robots in which the play is closed; where it is 0 or 1, nothing changes, and the draw is 0
    """
    differs = (closed > 0) & (closed < 1)
    open_ = np.where(differs, closed, 0.5)
    return np.asarray(np.where(u <= closed, np.sqrt((1 - open_) / open_), -np.sqrt(open_ / (1 - open_))) * differs)
