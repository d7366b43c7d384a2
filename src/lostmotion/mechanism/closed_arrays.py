"""A closed chain in arrays, as the compiled kernels take it, and what they share."""

from __future__ import annotations

from typing import TYPE_CHECKING, Final, NamedTuple

if TYPE_CHECKING:
    import numpy as np

ASSEMBLED, NOT_ASSEMBLED, SINGULAR = range(3)
# A closure counts as met below this misfit; Newton's last step is far below it.
MET: Final = 1e-9
LONGEST_STEP: Final = 0.3


class ChainArrays(NamedTuple):
    """A closed chain in arrays.

    parent, pose, drive, passive  of each place: index of its parent, fixed frame (place, 3, 4), and
                 the index of the driven or passive joint that moves it; -1 without
    twist        (place, 6) unit motion of a driven joint
    first        (passive + 1,) freedoms of each passive joint, one after the other
    freedom      (freedom, 6) unit motions of the passive joints
    of           (freedom,) place of each freedom
    sign         (closure, place) 1 and -1 where a place carries the first or the second frame alone
    ends, frame  (closure, 2) places that a closure joins, and (closure, 2, 3, 4) the frames there
    carries      (place,) whether a place carries the tool
    order        (freedom,) in which freedoms are eliminated: those of fewest closures first
    units        (freedom,) motions that count as one, rad or m
    moved        (drive,) place of each drive
    size         of the chain, m
    idle         number of freedoms that no closure holds
    """

    parent: np.ndarray
    pose: np.ndarray
    drive: np.ndarray
    passive: np.ndarray
    twist: np.ndarray
    first: np.ndarray
    freedom: np.ndarray
    of: np.ndarray
    sign: np.ndarray
    ends: np.ndarray
    frame: np.ndarray
    carries: np.ndarray
    order: np.ndarray
    units: np.ndarray
    moved: np.ndarray
    size: float
    idle: int
