"""The exact position of a closed chain with errors put into its places: Newton's method on the
closures, where every place is displaced and the parts within the loops deflect.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, Final

import numpy as np

from lostmotion.mechanism.carry import at_tool_point
from lostmotion.mechanism.closed_jacobian import balance, misfits, moved_on, signs
from lostmotion.spatial import exp, inverse

if TYPE_CHECKING:
    from collections.abc import Mapping

    from numpy.typing import NDArray

    from lostmotion.mechanism.closed_statics import Loops
    from lostmotion.spatial import Floats

_MOST_STEPS: Final = 30
# A last step below this, rad or as a share of the size of the chain, ends the search.
_CLOSED: Final = 1e-12


def composed(loops: Loops, twists: Mapping[int, Floats]) -> Floats:
    """Return the frames of the tool (pose, sample, 4, 4), m, with places displaced by twists (pose,
    sample, 6) in their own axes, rad and m; NaN where the chain does not assemble with them.

    Every place moves by the exponential of its twist. The passive joints follow, and the parts
    within loops deflect, until all closures are met; of loops of rigid parts, as far as they can.
    """
    tree, at = loops.tree, loops.at
    first = next(iter(twists.values()))
    poses, samples = first.shape[:2]
    steps = {
        k: np.repeat(inverse(at[place.parent]) @ at[k], samples, axis=0)
        for k, place in enumerate(tree.places[1:], start=1)
    }
    displaced = {k: each.reshape(-1, 6) for k, each in twists.items()}
    loads = np.zeros((poses * samples, 6 * len(tree.welds)))
    rows, columns = balance(tree)
    active = np.arange(poses * samples)
    frames = np.full((poses * samples, 4, 4), np.nan)
    passive = np.array([steps[each.place] for each in tree.passive])
    for _ in range(_MOST_STEPS):
        here = placed(loops, steps, passive, displaced, loads, active)
        away = misfits(tree, here).reshape(len(active), -1, 1)
        load, step = _of_poses(loops, away, active // samples)
        frames[active] = here[-1]
        left = np.abs(step / columns).max(axis=1, initial=0.0)
        left = np.maximum(left, np.abs(_given(loops, load, active // samples) * rows).max(axis=1))
        going = ~(left < _CLOSED) & (left < 1.0)
        frames[active[left >= 1.0]] = np.nan
        loads[active] += load
        passive[:, active] = moved_on(tree, passive[:, active], step)
        active = active[going]
        if not len(active):
            break
    frames[active] = np.nan
    return frames.reshape(poses, samples, 4, 4)


def _of_poses(loops: Loops, away: Floats, pose: NDArray[np.int64]) -> tuple[Floats, Floats]:
    """Return loads (sample, equation) and steps (sample, freedom) against misfits (sample,
    equation, 1) at these poses (sample,).
    """
    none = np.zeros((len(away), loops.columns.shape[2], 1))
    load, step = loops.rows(pose).solved(-away, none)
    return load[..., 0], step[..., 0]


def _given(loops: Loops, load: Floats, pose: NDArray[np.int64]) -> Floats:
    """Return what the closures give under loads (sample, equation) at these poses (sample,)."""
    return np.asarray(np.einsum("pij,pj->pi", loops.loop_compliance[pose], load))


def placed(
    loops: Loops,
    steps: Mapping[int, Floats],
    passive: Floats,
    displaced: Mapping[int, Floats],
    loads: Floats,
    active: NDArray[np.int64],
) -> Floats:
    """Return the frames (place, sample, 4, 4) of the displaced places."""
    tree, sign, samples = loops.tree, signs(loops.tree), len(loads) // loops.at.shape[1]
    pose = active // samples
    number = {each.place: k for k, each in enumerate(tree.passive)}
    out = np.empty((len(tree.places), len(active), 4, 4))
    out[0] = np.eye(4)
    for k, place in enumerate(tree.places):
        if k:
            step = passive[number[k], active] if k in number else steps[k][active]
            out[k] = out[place.parent] @ step
        own = displaced[k][active] if k in displaced else None
        if k in loops.compliance and sign[:, k].any() and not loops.exact:
            net = loops.on_place(k, loads[active][..., None])
            moved = at_tool_point(loops.at, k)[pose]
            wrench = np.einsum("pij,pi->pj", moved, net[..., 0])
            bent = np.einsum("pij,pj->pi", loops.compliance[k][pose], wrench)
            own = bent if own is None else own + bent
        if own is not None:
            out[k] = out[k] @ exp(own)
    return out
