"""How much the loads on the elastic parts change as the parts deflect: the product of compliance
and load gradient.

Its eigenvalues are the shares of the stiffness that the load takes away. Where the largest is one,
the tangent of the equilibrium is singular; above one the arm falls. Weights keep their direction;
the process force and moment turn with the tool.
"""

from __future__ import annotations

import itertools
from typing import TYPE_CHECKING, Final, NamedTuple

import numpy as np

from lostmotion.mechanism.frames import place_frames
from lostmotion.mechanism.places import PlacedMass
from lostmotion.parts.term import Condition
from lostmotion.spatial import cross, out_of

if TYPE_CHECKING:
    from collections.abc import Sequence

    from lostmotion.mechanism.placed_terms import PlacedTerm
    from lostmotion.mechanism.places import Tree
    from lostmotion.mechanism.tool import Payload
    from lostmotion.spatial import Floats

# Shares of the stiffness that a load takes away: in all, of an arm that needs no tangent, and of
# freedoms that are neglected in it.
_STIFF: Final = 0.25
_NEGLECTED: Final = 0.02
# Loads at which compliances are compared, N m and N.
_LOADS: Final = np.array([0.0, 1.0, 10.0, 100.0, 1000.0])


class Freedom(NamedTuple):
    """A direction in which a part deflects: the index of its place, and the component of the twist
    there, 0 to 5.
    """

    place: int
    component: int


def soft_freedoms(
    tree: Tree, limits: Floats, payload: Payload, gravity: float, springs: Sequence[PlacedTerm]
) -> tuple[Freedom, ...]:
    """Return the freedoms in which the loads take away a share of the stiffness that matters; none
    where it is less than 25 % of it in every pose.

    limits   (joint, 2) rad or m, of the driven joints
    gravity  size of the acceleration of free fall, m/s^2
    springs  the terms that deflect under load

    Let a_k be the turn at place k, or its displacement over the reach R outboard of it. A weight m
    g moves by at most R (sum a_k)^2 to second order. With compliances c_k the share is therefore at
    most the sum of c_k m g R over the places (Cauchy-Schwarz); it is doubled, since the compliances
    are those at a few loads. Freedoms that add up to 2 % are neglected.
    """
    places = len(tree.places)
    at = place_frames(tree, np.stack([limits[:, 0], limits.mean(axis=1), limits[:, 1]]))
    reach, weight, turning = np.zeros((3, places))
    for k in range(places - 1, 0, -1):
        parent = tree.places[k].parent
        step = float(np.linalg.norm(at[k, :, :3, 3] - at[parent, :, :3, 3], axis=1).max())
        own = [float(np.linalg.norm(each.centre)) for each in tree.masses if each.at == k]
        reach[k] = max(reach[k], *own, 0.0)
        reach[parent] = max(reach[parent], reach[k] + step)
        weight[k] += gravity * sum(each.mass for each in tree.masses if each.on == k)
        if k == places - 1:
            weight[k] += gravity * payload.mass + float(np.linalg.norm(payload.force))
            turning[k] = float(np.linalg.norm(payload.moment))
            reach[k] = max(reach[k], float(np.linalg.norm(payload.centre_of_mass)))
            reach[parent] = max(reach[parent], reach[k] + step)
        weight[parent] += weight[k]
        turning[parent] += turning[k]
    gradient = np.empty((places, 6))
    gradient[:, :3] = (weight * reach + turning)[:, None]
    far = np.where(reach > 0, reach, np.inf)
    gradient[:, 3:] = (weight / far + turning / far**2)[:, None]
    shares = 2 * gradient * _largest_compliances(places, springs)
    order = np.argsort(shares, axis=None)
    kept = order[np.cumsum(shares.ravel()[order]) > _NEGLECTED]
    if shares.sum() < _STIFF:
        return ()
    return tuple(sorted(Freedom(int(k) // 6, int(k) % 6) for k in kept))


def _largest_compliances(places: int, springs: Sequence[PlacedTerm]) -> Floats:
    """Return the largest compliance in each freedom (place, 6), over loads of several sizes."""
    count = len(_LOADS)
    at = Condition(np.zeros(count), np.tile(_LOADS, (6, 1)), np.zeros((3, count)))
    out = np.zeros((places, 6))
    for placed in springs:
        own = placed.term.scale * placed.term.form.compliance(at)
        out[placed.place] += np.abs(np.diagonal(own, axis1=1, axis2=2)).max(axis=0)
    return out


def load_gradient(
    tree: Tree,
    at: Floats,
    payload: Payload,
    gravity: Floats,
    freedoms: Sequence[Freedom],
    places: Sequence[int] | None = None,
) -> Floats:
    """Return the change of the wrench on each place (place, pose, 6, freedom), in its own axes, per
    displacement of each freedom, N m and N per rad and m.

    at      (place, pose, 4, 4) frames of the places, m; other arguments as `place_wrenches`
    places  those whose wrenches are returned; by default all

    A displacement at a place, or inboard of it, turns the place under the weights; one outboard of
    it moves the weights themselves. The process force and moment turn with the tool.
    """
    tool, poses = len(at) - 1, at.shape[1]
    held = PlacedMass(tool, tool, payload.mass, np.array(payload.centre_of_mass))
    weights = [each for each in (*tree.masses, held) if each.mass]
    points = [at[each.at][:, :3, 3] + out_of(at[each.at], each.centre) for each in weights]
    force, moment = (out_of(at[-1], np.array(each)) for each in (payload.force, payload.moment))
    outboard = [tree.outboard(k) for k in range(len(at))]
    wanted = range(len(at)) if places is None else places
    out = np.zeros((len(wanted), poses, 6, len(freedoms)))

    def moments_of(k: int, members: Sequence[int]) -> tuple[float, Floats]:
        """Return the mass of these weights, and its first moment about place k."""
        first = sum(
            (weights[w].mass * (points[w] - at[k][:, :3, 3]) for w in members),
            start=np.zeros((poses, 3)),
        )
        return sum(weights[w].mass for w in members), first

    # of each place what loads it, and what moves with it
    loading, moving = (
        {
            k: moments_of(k, [w for w, carrier in enumerate(carriers) if carrier in outboard[k]])
            for k in here
        }
        for carriers, here in (
            ([each.on for each in weights], wanted),
            ([each.at for each in weights], {each.place for each in freedoms}),
        )
    )
    for place, group in itertools.groupby(enumerate(freedoms), lambda each: each[1].place):
        numbers, components = zip(*((j, each.component) for j, each in group), strict=True)
        motion = np.zeros((2, len(numbers), poses, 3))
        for m, component in enumerate(components):
            motion[component // 3, m] = at[place][:, :3, component % 3]
        turn, shift = motion
        falls = cross(turn, gravity[None])
        origin = at[place][:, :3, 3]
        turned = cross(turn, force) * (tool in outboard[place])
        # change of the moment of what the freedom moves
        moved = cross(cross(turn, at[-1][:, :3, 3] - origin) + shift, force) + cross(turn, moment)
        moved *= tool in outboard[place]
        mass, first = moving[place]
        moved += cross(cross(turn, first) + mass * shift, gravity[None])
        for n, k in enumerate(wanted):
            if not (k in outboard[place] or place in outboard[k]):
                continue
            if k in outboard[place]:
                mass, first = loading[k]
                changes = -cross(first, falls), -mass * falls
            else:
                changes = moved + cross(at[-1][:, :3, 3] - at[k][:, :3, 3], turned), turned
            change = np.stack(changes)
            local = sum(at[k][:, j, :3] * change[..., j, None] for j in range(3))
            own = slice(numbers[0], numbers[-1] + 1)
            out[n, :, :, own] = local.transpose(2, 0, 3, 1).reshape(poses, 6, len(numbers))
    return out
