"""Elastic bodies of an envelope stage with the contacts of both branches, reduced to the contacts
of the first branch.

Every contact of either branch is a Hertz contact by Johnson's law, and the bodies of exact profile
(`lobed_wheel`) couple all of them. Where two of them come close, or one reaches over the junction
of the branches, they are one wide contact:

- The displacement of one contact by another at the distance s has the logarithm of the root of s^2
  + [exp(-1/2) (a_i + a_j)/2]^2, with half-widths a. At s = 0 two equal contacts then approach as a
  single one under both forces. Contacts closer than a tenth of a_i + a_j are that single one.
- At the junction the curvature of the gap falls to zero, because the hollow of the second branch
  fits there. A contact at a distance x from it that is smaller than its half-width has the mean
  curvature over its width 2 h, k (1 + x/h)/2 + k' (1 - x/h)/2, with k' of the other side. Its law
  is then shifted so that, on half-planes, it carries under the reference load what it carries by
  the contact along the whole flank (`envelope_contact`).

The equilibrium of all contacts is solved once per position of the lobes, without gaps, under a
reference load. Each contact of the second branch is divided between its neighbours of the first
branch. Their compliance, with all forces in the ratios of that equilibrium, is the reduced one:
exact at the reference load, and stiffening with the load as Johnson's law does. So a force of the
reduced stage is that of a lobe with its share of the second branch, and its gap is that of the
lobe. Valid for static load without friction, to first order in the displacements. The rotation is
within 1 % of finite elements, mostly 0.3 %.

Source: K. Johnson, Contact Mechanics, 1985, sections 4.2 and 5.6; reduction by virtual work.
Compared with contact by finite elements in the tests.
"""

from __future__ import annotations

import functools
import math
from typing import TYPE_CHECKING, Final

import numpy as np

from lostmotion.errors import DidNotConvergeError
from lostmotion.laws.contact import johnson_scale
from lostmotion.laws.cycloid.bodies import flexibility_with_second
from lostmotion.laws.cycloid.envelope_contact import johnson_depth
from lostmotion.laws.cycloid.flank_contacts import (
    contacts_of_both,
    distances,
    merging,
    reference_torque,
)

if TYPE_CHECKING:
    import numpy.typing as npt

    from lostmotion.laws.cycloid.bodies import ElasticBody
    from lostmotion.laws.cycloid.contact import Flanks
    from lostmotion.laws.cycloid.stage import Stage
    from lostmotion.spatial import Floats

    Complexes = npt.NDArray[np.complex128]

# Distances, over that sum, below which they are a single contact, because their equations are
# nearly dependent; the later ones where these fail.
_SAME: Final = (0.1, 0.3, 1.0)
# Distance from a contact of the second branch, over the pitch, within which one of the first branch
# takes part of its force even without its own.
_BESIDE: Final = 1 / 16


def reduced_flexibility(
    stage: Stage, bodies: tuple[ElasticBody, ...], flanks: Flanks, crank: Floats
) -> tuple[Floats, Floats, Floats]:
    """Return the displacements (m/N) along contact i of the first branch under a unit force at
    contact j: (side, crank, N, N), symmetric.

    bodies  the elastic ones of disc and ring
    flanks  width and modulus, for Johnson's law
    crank   (crank,) crank angles, rad

    And by how many times each contact is stiffer than by that law, and the share of its force that
    counts for its pressure, both (crank, N). Raises DidNotConvergeError, and errors as
    `bodies.flexibility`.
    """
    pitch = 2 * math.pi / stage.pins
    out = np.empty((2, len(crank), stage.pins, stage.pins))
    stiffer, pressed = np.empty((2, len(crank), stage.pins))
    for k, angle in enumerate(np.asarray(crank, dtype=float).tolist()):
        turns = math.floor(angle / pitch + 1e-9)
        each, share, wide = _reduced(stage, bodies, flanks, round(angle - turns * pitch, 12) + 0.0)
        out[:, k], stiffer[k], pressed[k] = (
            np.roll(each, (turns, turns), axis=(1, 2)),
            np.roll(1 / share, turns),
            np.roll(share / wide**2, turns),
        )
    return out, stiffer, pressed


@functools.lru_cache(maxsize=256)
def _reduced(
    stage: Stage, bodies: tuple[ElasticBody, ...], flanks: Flanks, crank: float
) -> tuple[Floats, Floats, Floats]:
    """Return the displacements of `reduced_flexibility` at one crank angle, each contact's share of
    its force, and how many times wider it is.
    """
    for same in _SAME[:-1]:
        try:
            return _reduced_beyond(stage, bodies, flanks, crank, same)
        except DidNotConvergeError:  # of contacts that nearly coincide
            continue
    return _reduced_beyond(stage, bodies, flanks, crank, _SAME[-1])


def _reduced_beyond(
    stage: Stage, bodies: tuple[ElasticBody, ...], flanks: Flanks, crank: float, same: float
) -> tuple[Floats, Floats, Floats]:
    """Return `_reduced` with contacts of the second branch that are farther than `same` times the
    half-widths from those of the first one.
    """
    given = contacts_of_both(stage, crank, same)
    second, theta, arm, radius, half, places = (
        given.second,
        given.theta,
        given.arm,
        given.radius,
        given.half,
        given.places,
    )
    n = stage.pins
    soft = 1 / (math.pi * flanks.modulus * flanks.width)
    torque = flanks.modulus * flanks.width * reference_torque(stage)
    # The law of the contact ends at the depth of Johnson's law for `local`: within it the modulus
    # is that of the contact, beyond that of the body.
    depth = johnson_depth(stage)
    local = np.append(radius[:n], np.full(len(second), depth * math.e / 2))
    beyond = -np.diag(np.log(local / radius))
    apart = distances(places, half)
    near = np.log(np.maximum(depth / apart, 1.0)) * (1 - np.eye(len(theta)))
    moved = 2 * soft * np.broadcast_to(near, (2, *near.shape))
    for body in bodies:
        plane = (
            2
            * (1 - body.nu**2 if body.plane == "strain" else 1.0)
            / body.young
            / (math.pi * flanks.width)
        )
        moved = (
            moved
            + flexibility_with_second(stage, body, flanks.width, crank, second)
            + plane * (beyond - merging(places, half) - near)
        )
    scales = (
        np.log(johnson_scale(flanks.width, given.merged, flanks.modulus))
        - 2 * np.log(given.merged / local)
        + given.extra
    )
    own = np.log(johnson_scale(flanks.width, radius[:n], flanks.modulus))
    parts = np.eye(n, len(theta))
    rest, share = np.empty(n), np.ones(n)
    for side, sign in enumerate((1.0, -1.0)):
        scale = scales[side]
        force = _equilibrium(
            sign * torque, arm, soft, scale, moved[side], stage.planet_pitch_radius
        )
        approach = soft * force * (scale - np.log(np.where(force > 0, force, 1.0)))
        mine = np.flatnonzero(sign * arm[:n] >= 0)
        lumped = _lumped(np.abs(theta), sign * arm, force, n)
        for k in mine:
            at = lumped[k].sum()
            if at > 0:
                total = float(lumped[k] @ arm) / arm[k] if at > force[k] else force[k]
                parts[k] = lumped[k] / total
                share[k] = parts[k] @ force / total
                rest[k] = parts[k] @ approach / total - soft * share[k] * (own[k] - math.log(total))
            else:
                rest[k] = soft * (scale[k] - own[k])
    return (
        np.asarray(parts @ moved @ parts.T + np.diag(rest)),
        share,
        np.sqrt(given.merged / radius)[:n],
    )


def _lumped(angle: Floats, arm: Floats, force: Floats, n: int) -> Floats:
    """Return the part (N, contact), N, of every force that is counted with each contact of the
    first branch.

    angle  (contact,) from the line of centres, 0 to pi
    arm    (contact,) m, positive where it drives

    A force of the second branch is divided between the loaded neighbours of the first branch, by
    distance and arm. One beside it counts as loaded.
    """
    out = np.diag(force)[:n].copy()
    second = n + np.flatnonzero((force[n:] > 0) & (arm[n:] > 0))
    beside = (np.abs(angle[:n, None] - angle[second]) < _BESIDE * 2 * math.pi / n).any(axis=1)
    loaded = np.flatnonzero(((force[:n] > 0) | beside) & (arm[:n] > 0))
    loaded = loaded[np.argsort(angle[loaded])]
    for j in second:
        after = int(np.clip(np.searchsorted(angle[loaded], angle[j]), 1, len(loaded) - 1))
        pair = loaded[[after - 1, after]]
        near = np.clip((angle[pair[1]] - angle[j]) / (angle[pair[1]] - angle[pair[0]]), 0.0, 1.0)
        share = np.array([near, 1 - near]) * arm[pair]
        out[pair, j] += force[j] * share / share.sum()
    return out


def _equilibrium(
    torque: float, arm: Floats, soft: float, scale: Floats, moved: Floats, lever: float
) -> Floats:
    """Return the force of every contact (N) under a torque (N m) with a rigid eccentric. Raises
    DidNotConvergeError.
    """
    from lostmotion.compiled import read_only
    from lostmotion.laws.cycloid import contact_kernel as kernel
    from lostmotion.laws.cycloid import elastic_kernel

    count = len(arm)
    out, forces = np.empty((1, kernel.COLUMNS)), np.empty((1, count))
    one = np.ones((1, count))
    both = np.ascontiguousarray(np.broadcast_to(moved, (2, 1, count, count)))
    given = read_only(
        kernel.LOGARITHMIC,
        lever,
        0.0,
        np.array([torque]),
        np.zeros(1, dtype=np.int64),
        0 * one,
        arm[None] / lever,
        soft * one,
        scale[None],
        np.inf * one,
        np.zeros((1, 1, count)),
        np.array([[np.inf]]),
        both,
    )
    elastic_kernel.solve_cases(0, 1, *given, out, forces)
    if not np.isfinite(out[0, kernel.ROTATION]):
        raise DidNotConvergeError(
            "no equilibrium of the contacts of both branches was found under the reference load"
        )
    return np.asarray(forces[0])
