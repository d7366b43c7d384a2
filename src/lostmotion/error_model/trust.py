"""Poses that have no figure of the error: those at which first order is not valid in a closed
chain, near a parallel singularity, and those at which a soft arm falls.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, Final

import numpy as np

from lostmotion.error_model.open_plays import open_play_remarks
from lostmotion.error_model.pose_matrix import screws
from lostmotion.errors import InputError, Problem
from lostmotion.mechanism.assembly import may_not_assemble
from lostmotion.mechanism.closed_jacobian import twist_units
from lostmotion.mechanism.closed_loads import load_remarks
from lostmotion.mechanism.closed_trust import loosest, share_neglected
from lostmotion.mechanism.even_poses import few_even_poses
from lostmotion.mechanism.placed_terms import short_name
from lostmotion.mechanism.standing import falls_at, refuse_falling
from lostmotion.mechanism.state import state_of

if TYPE_CHECKING:
    from collections.abc import Sequence

    from numpy.typing import NDArray

    from lostmotion.error_model.pose_matrix import PoseMatrix
    from lostmotion.error_model.poses import Poses
    from lostmotion.mechanism.arm import Arm
    from lostmotion.spatial import Floats

# No figure where first order neglects a larger share of the error.
FAILS: Final = 0.1
# Figures are refused where more than this share of the poses has none: a 95th percentile of the
# rest would not be one of the workspace.
_MOST_WITHOUT: Final = 0.05
# Standard deviations of the error along the loose direction at which the share is taken.
_DEVIATIONS: Final = 2.0
# The same for soft arms that fall: where they do at most poses, no figure describes them.
_MOST_FALLING: Final = 0.5
_BLOCK: Final = 256
_EXCLUDED: Final = (
    f"Poses above {100 * FAILS:g} % have no figure of the error: sampled ones are excluded, and as "
    "many of each set"
)
# Share below which first order is valid at poses of smaller gain.
_SMALL: Final = 0.01


@dataclass(frozen=True)
class Trust:
    """How far first order is valid at poses.

    neglected  (pose,) share of the error that first order neglects
    direction  (pose, 6) unit twist of the tool that errors of the drives move most: rotation, and
               shift as a share of the size of the chain
    part       (pose,) name of the part that adds most to the mean-square error along it
    """

    neglected: Floats
    direction: Floats
    part: NDArray[np.str_]

    @property
    def valid(self) -> NDArray[np.bool_]:
        """Return whether (pose,) first order is valid."""
        return np.asarray(self.neglected <= FAILS)

    def refuse(self, arm: Arm, most: float) -> None:
        """Raise InputError where first order is not valid at more than this share of the poses of
        this arm.
        """
        if 1 - self.valid.mean() > most:
            raise _refusal(arm, self)


def trust(arm: Arm, q: Floats) -> Trust:
    """Return how far first order is valid in a closed chain at these values of the driven joints
    (pose, joint), at which it is assembled.

    The errors are those whose draws most likely move the tool by two standard deviations along its
    loose direction, to either side, besides those without draws; the larger share counts. It grows
    with the gain: poses are evaluated from the largest gain on, until it is below 1 % at 256
    successive ones. It counts as zero at the others.
    """
    direction, gains = loosest(arm.tree, q)
    neglected, part = np.zeros(len(q)), np.full(len(q), "", dtype=object)
    order = np.argsort(-gains, kind="stable")
    for first in range(0, len(q), _BLOCK):
        rows = order[first : first + _BLOCK]
        neglected[rows], part[rows] = _at(arm, q[rows], direction[rows])
        if neglected[rows].max() < _SMALL:
            break
    return Trust(neglected, direction, part)


def _at(arm: Arm, q: Floats, direction: Floats) -> tuple[Floats, NDArray[np.str_]]:
    """Return the neglected share, and the part that adds most, at each pose (pose,)."""
    matrix = screws(state_of(arm, q))
    loops = matrix.state.closed
    if loops is None or not len(matrix.infos):
        return np.zeros(len(q)), np.full(len(q), "")
    along = np.einsum("pi,i,pik->pk", direction, twist_units(arm.tree), matrix.tool)
    draws, shares = np.zeros_like(along), np.zeros_like(along)
    for columns in matrix.groups.values():
        together = along[:, columns].sum(axis=1)
        shares[:, columns] = together[:, None] * along[:, columns]
        if matrix.infos[columns[0]].draws:
            draws[:, columns] = together[:, None]
    drawn = np.array([bool(each.draws) for each in matrix.infos])
    spread = np.sqrt(shares[:, drawn].sum(axis=1))
    draws *= _DEVIATIONS / np.where(spread > 0, spread, 1.0)[:, None]
    sides = [
        share_neglected(loops[0], _twists(matrix, np.where(drawn, sign * draws, 1.0)))
        for sign in (1.0, -1.0)
    ]
    owners = [each.of.owner for each in matrix.infos]
    names = list(dict.fromkeys(owners))
    by_part = np.zeros((len(q), len(names)))
    for k, owner in enumerate(owners):
        by_part[:, names.index(owner)] += shares[:, k]
    part = np.array([short_name(name) for name in names])[by_part.argmax(axis=1)]
    return np.maximum(*sides), part


def _twists(matrix: PoseMatrix, draws: Floats) -> dict[int, Floats]:
    """Return the twists (pose, 6) of all places for draws (pose, column)."""
    out = {}
    for place in np.unique(matrix.place).tolist():
        own = matrix.place == place
        out[place] = np.einsum("pik,pk->pi", matrix.local[:, :, own], draws[:, own])
    return out


def trusted(arm: Arm, q: Floats) -> NDArray[np.bool_]:
    """Return whether (pose,) a figure can be stated at each of these poses (pose, joint): first
    order is valid in a closed chain, an open one stands.
    """
    if not may_not_assemble(arm):
        return np.asarray(falls_at(arm, q) < 0)
    return trust(arm, q).valid


def refuse_untrusted(arm: Arm, q: Floats, most: float = _MOST_WITHOUT) -> None:
    """Raise InputError where first order is not valid at more than this share of the poses, or a
    soft arm falls at more than half of them.
    """
    if may_not_assemble(arm):
        trust(arm, q).refuse(arm, most)
    else:
        refuse_falling(arm, q, falls_at(arm, q), _MOST_FALLING if most else 0.0)


def with_figures(
    arm: Arm, poses: Poses, *, beside: Sequence[Arm] = (), most: float | None = None
) -> Poses:
    """Return the poses without those at which first order is not valid in a closed chain, and those
    at which the springs of a soft arm cannot hold its load.

    beside  other arms that stand at the same poses, and that must have figures there
    most    largest share of sampled poses without a figure; by default 5 % of a closed chain, and
            half of a soft arm

    Of independent sets as many poses are kept in each. Raises InputError where poses that are given
    have one such pose, and where more than `most` of sampled ones are.
    """
    if may_not_assemble(arm):
        validity = trust(arm, poses.q)
        share = _MOST_WITHOUT if most is None else most
        validity.refuse(arm, 0.0 if poses.law == "given" else share)
        own = validity.valid
    else:
        own = _standing(arm, poses, _MOST_FALLING if most is None else most)
    valid = np.all([own, *(trusted(other, poses.q) for other in beside)], axis=0)
    return _kept(poses, valid)


def where_it_stands(arm: Arm, poses: Poses) -> Poses:
    """Return the poses without those at which the springs of a soft arm cannot hold its load, as
    `with_figures`; all for a stiff one, and a closed chain.
    """
    return _kept(poses, _standing(arm, poses, _MOST_FALLING))


def _standing(arm: Arm, poses: Poses, most: float) -> NDArray[np.bool_]:
    places = falls_at(arm, poses.q)
    refuse_falling(arm, poses.q, places, 0.0 if poses.law == "given" else most)
    return np.asarray(places < 0)


def _kept(poses: Poses, valid: NDArray[np.bool_]) -> Poses:
    """Return the valid poses, as many of each set."""
    if valid.all():
        return poses
    sets = valid.reshape(poses.replicates, -1)
    each = int(sets.sum(axis=1).min())
    if not each:  # a set without any: those of all sets as one
        return replace(poses, q=poses.q[valid], replicates=1)
    rows = [np.flatnonzero(row)[:each] + k * len(row) for k, row in enumerate(sets)]
    return replace(poses, q=poses.q[np.concatenate(rows)])


def _refusal(arm: Arm, validity: Trust) -> InputError:
    failing, poses = np.count_nonzero(~validity.valid), len(validity.valid)
    found = (
        f"first order neglects more than {100 * FAILS:g} % of the error at {failing} of {poses} "
        f"poses, {_worst(validity)}"
    )
    at_home = trust(arm, arm.home[None])
    if at_home.valid.all():
        ranges = "narrower limits of the drives" if arm.workspace is None else "a smaller box"
        expected = f"poses farther from a parallel singularity: {ranges}; or smaller errors"
        return InputError([Problem("", "poses", found, expected)])
    part = at_home.part[0]
    found += f"; and at home: errors as large as those of {part} change the shape of the chain"
    return InputError([Problem(arm.name, "", found, f"smaller errors, of {part} first")])


def _worst(validity: Trust) -> str:
    """Return where first order neglects most, in which direction, and by which part."""
    k = int(validity.neglected.argmax())
    share = validity.neglected[k]
    turn, shift = validity.direction[k, :3], validity.direction[k, 3:]
    sliding = np.linalg.norm(shift) >= np.linalg.norm(turn)
    way = shift if sliding else turn
    way = way / np.linalg.norm(way)
    axes = ", ".join(f"{value + 0.0:.2f}" for value in np.round(way, 2))
    size = f"{100 * share:.3g} %" if share < 1 else "all of it"
    return (
        f"{size} at most; there the tool is loose {'along' if sliding else 'in rotation about'} "
        f"({axes}) in the base's axes, and {validity.part[k]} adds most to the error in this "
        "direction"
    )


def error_remarks(arm: Arm) -> tuple[str, ...]:
    """Return the remarks on an arm whose errors are predicted: where first order fails, plays that
    stay open, loads that change the stiffness, and what its file leaves open.
    """
    return *trust_remarks(arm), *open_play_remarks(arm), *load_remarks(arm), *arm.remarks


def trust_remarks(arm: Arm) -> tuple[str, ...]:
    """Return the remark on the poses of a closed chain that have no figure, of 256 spread evenly
    between the limits of the drives, whatever poses were studied; none for an open chain, and where
    first order neglects less than 1 %.
    """
    if not may_not_assemble(arm):
        return ()
    found = trust(arm, few_even_poses(arm))
    count, of = int(np.count_nonzero(~found.valid)), len(found.neglected)
    if not count:
        largest = found.neglected.max(initial=0.0)
        return (
            (
                (
                    f"share of the error that first order neglects, of {of} poses spread evenly: "
                    f"{_worst(found)}. {_EXCLUDED}"
                ),
            )
            if largest > _SMALL
            else ()
        )
    return (
        (
            f"at {count} of {of} poses spread evenly first order neglects more than "
            f"{100 * FAILS:g} % of the error: {_worst(found)}. {_EXCLUDED}"
        ),
    )
