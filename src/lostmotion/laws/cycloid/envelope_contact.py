"""Contact of the disc with an envelope ring along its whole flank, where contacts of both branches
merge: wind-up and pressure.

Both contacts of a flank near the junction of the two branches are one wide contact, and the hollow
of the second branch fits the disc almost exactly. So neither is a Hertz contact of its own. Here
each flank of the disc is divided into short elements of uniform pressure, which never pull. The
normal displacement by a pressure p on an element at the distance s is that of two half-planes, 2
p/(pi E*) ln(d/s) per length. It ends at a distance d: the rest of the bodies is not included, as in
Johnson's law, with which a single contact agrees for d = 2 Req/exp(1).

Valid for a rigid eccentric, static load without friction, and contacts that are small compared with
the lobes. Its largest pressures agree with finite elements to 6 %.

Source: K. Johnson, Contact Mechanics, 1985, sections 2.2 and 5.9 (line loads, pressure in
elements); equilibrium as an active set of elements.
"""

from __future__ import annotations

import functools
import math
from dataclasses import dataclass
from typing import TYPE_CHECKING, Final

import numpy as np

from lostmotion.errors import DidNotConvergeError
from lostmotion.laws.cycloid.contact import Flanks
from lostmotion.laws.cycloid.flank_distance import FlankDistance, candidates
from lostmotion.laws.cycloid.geometry import arms, contact_radius, gaps, pin_angles
from lostmotion.laws.cycloid.stage import Modification

if TYPE_CHECKING:
    from collections.abc import Sequence

    from lostmotion.laws.cycloid.stage import Stage
    from lostmotion.spatial import Floats

# Elements per half-width of the largest separate contact. Half as many change the wind-up by 0.1 %.
_FINE: Final = 10
_STEPS: Final = 60
# Unbalanced torque, as a share, at which separate contacts are in equilibrium.
_BALANCED: Final = 1e-13
_DEPTHS: Final = 400
_ANGLES: Final = 6
# Largest load per width, over E* and the radius of the lobes, at which the stiffening is computed.
_LOAD: Final = 2.5e-4


@dataclass(frozen=True, slots=True)
class EnvelopeContact:
    """Equilibrium of one disc on an envelope ring; each (crank,).

    rotation  of the disc from its position without gaps, rad
    alone     rotation with the contacts of the first branch alone, each a Hertz contact to the same
              depth, rad
    peak      largest pressure, Pa
    largest   largest force of one contact area, N
    areas     number of contact areas
    """

    rotation: Floats
    alone: Floats
    peak: Floats
    largest: Floats
    areas: Floats


@functools.lru_cache(maxsize=64)
def johnson_depth(stage: Stage) -> float:
    """Return the depth d = 2 Req/exp(1), m, with which a contact approaches as by Johnson's law, of
    the mean contact.

    The mean of ln Req over the loaded half of the first branch, weighted by the squared arms, as
    the contacts share the wind-up.
    """
    theta = (np.arange(_DEPTHS) + 0.5) * math.pi / _DEPTHS
    return (
        2
        / math.e
        * math.exp(
            float(np.average(np.log(contact_radius(stage, theta)), weights=arms(stage, theta) ** 2))
        )
    )


@functools.lru_cache(maxsize=64)
def stiffening_by_solution(stage: Stage) -> float:
    """Return by how many times the second branch stiffens the contacts of the first one, by the
    contact along the whole flank without gaps.

    Averaged over a pitch of the crank, to `johnson_depth`, under the load of a steel lobe of 3.5 mm
    with 100 N/mm. A third or three times that load changes the result by 1 %. Raises ValueError for
    another kind of stage.
    """
    flanks = Flanks(1.0, 1.0)
    torque = _LOAD * stage.pin_radius * stage.planet_pitch_radius * stage.pins / 4
    crank = 2 * math.pi / stage.pins * (np.arange(_ANGLES) + 0.5) / _ANGLES
    found = envelope_contact(stage, flanks, torque, crank)
    return float(found.alone.mean() / found.rotation.mean())


def envelope_contact(
    stage: Stage,
    flanks: Flanks,
    torque: float,
    crank: Floats | Sequence[float],
    relief: Modification | None = None,
    depth: float | None = None,
) -> EnvelopeContact:
    """Return the equilibrium of one disc on an envelope ring under a torque (N m, positive) at
    crank angles (crank,), rad.

    flanks  their width and modulus; law and bending are not used
    relief  of the disc
    depth   d, m, at which the displacement by a pressure ends; default: `johnson_depth`

    Raises ValueError for another kind of stage, DidNotConvergeError where the load is beyond the
    law of a contact or no equilibrium is found.
    """
    if stage.kind != "lobe envelope":
        raise ValueError(f"a stage with {stage.kind} has no second branch")
    to = johnson_depth(stage) if depth is None else depth
    found = [
        _solved(stage, flanks, torque, float(each), relief or Modification(), to) for each in crank
    ]
    return EnvelopeContact(*(np.array(each) for each in zip(*found, strict=True)))


def separate_contacts(
    stage: Stage,
    flanks: Flanks,
    torque: float,
    crank: float,
    relief: Modification,
    depth: Floats | float,
) -> tuple[float, Floats]:
    """Return the rotation (rad) of a disc on the first branch alone, and the load per width (N/m)
    of each driving contact.

    Each is a Hertz contact: delta = p/(pi E*) ln(pi E* d^2 exp(1)/(p Req)). Arguments and errors as
    `envelope_contact`; depth one or (N,).
    """
    from scipy.special import lambertw

    theta = pin_angles(stage, np.array([crank]))[0]
    arm, gap = np.maximum(arms(stage, theta), 0.0), gaps(stage, theta, relief)
    scale = (
        math.pi * flanks.modulus * math.e * np.asarray(depth) ** 2 / contact_radius(stage, theta)
    )
    wanted = torque / flanks.width

    def loads(rotation: float) -> tuple[Floats, float]:
        height = math.pi * flanks.modulus * np.maximum(arm * rotation - gap, 0.0) / scale
        if (height > math.exp(-1)).any():
            raise DidNotConvergeError("the load is beyond the law of separate contacts")
        safe = np.where(height > 0, height, math.exp(-1))
        logarithm = -lambertw(-safe, -1).real
        slope = np.where(height > 0, math.pi * flanks.modulus * arm / (logarithm - 1), 0.0)
        return np.where(height > 0, scale * height / logarithm, 0.0), float(slope @ arm)

    high = first = float(np.min(gap[arm > 0] / arm[arm > 0]))
    step = wanted / (math.pi * flanks.modulus * stage.planet_pitch_radius**2)
    while float(loads(high)[0] @ arm) < wanted:
        step *= 1.5
        high = first + step
    rotation = high
    # every load is a convex function of the rotation, so that Newton's method approaches from above
    for _ in range(_STEPS):
        found, slope = loads(rotation)
        excess = float(found @ arm) - wanted
        if excess <= _BALANCED * wanted:
            break
        rotation -= excess / slope
    return rotation, found


def _solved(
    stage: Stage, flanks: Flanks, torque: float, crank: float, relief: Modification, depth: float
) -> tuple[float, ...]:
    # The first branch alone is softer, so its rotation bounds the true one.
    alone, loads = separate_contacts(stage, flanks, torque, crank, relief, depth)
    reach = contact_radius(stage, pin_angles(stage, np.array([crank]))[0])
    size = math.sqrt(4 * float((loads * reach).max()) / (math.pi * flanks.modulus)) / _FINE
    parts = candidates(stage, flanks.modulus, crank, relief, depth, size, alone)
    rotation = _equilibrium(parts, torque / flanks.width / size)
    areas = np.concatenate([_areas(each) for each in parts]) * size * flanks.width
    return (
        rotation,
        alone,
        max(float(each.pressure.max()) for each in parts),
        float(areas.max()),
        float(len(areas)),
    )


def flank_moments(
    stage: Stage, crank: float, lobe: int, rotation: float, half: float, depth: float, theta: Floats
) -> Floats:
    """Return the moments (contact,) per width and modulus E* (m) on one flank of a disc that is
    turned by `rotation` (rad), by its whole contact.

    crank  rad
    lobe   of the disc, counted from the line of centres at crank zero; its flank is that with
           positive arms
    half   half-width of its contact, m, roughly; depth: as for `envelope_contact`
    theta  (contact,) of its contacts, rad, between which its pressure is divided

    Raises DidNotConvergeError.
    """
    parts = candidates(stage, 1.0, crank, Modification(), depth, half / _FINE, rotation, lobe=lobe)
    _equilibrium(parts, None, rotation)
    out = np.zeros(len(theta))
    for each in parts:
        nearest = np.abs(each.theta[:, None] - theta).argmin(axis=1)
        np.add.at(out, nearest, each.pressure * each.arm * half / _FINE)
    return out


def _areas(part: FlankDistance) -> Floats:
    """Return the sum of the pressures of each contact area of a flank."""
    loaded = part.pressure > 0
    ends = loaded & np.append(~loaded[1:] | (np.diff(part.place) > 1), True)
    return np.diff(np.cumsum(part.pressure)[ends], prepend=0.0)


def _equilibrium(parts: list[FlankDistance], torque: float | None, rotation: float = 0.0) -> float:
    """Return the rotation (rad) at which all pressures balance a torque per width and element
    (N/m), and write the pressures to the parts.

    Without a torque the rotation is the given one. An element with a negative pressure is released,
    one that overlaps is added, until neither exists. Raises DidNotConvergeError.
    """
    from scipy.linalg import cho_factor, cho_solve

    for _ in range(_STEPS):
        stiff = free = 0.0
        pushed = []
        for each in parts:
            here = each.touching
            both = np.stack([each.arm[here], each.gap[here]], axis=1)
            solved = (
                cho_solve(cho_factor(each.influence[np.ix_(here, here)]), both)
                if here.any()
                else both
            )
            stiff += float(each.arm[here] @ solved[:, 0])
            free += float(each.arm[here] @ solved[:, 1])
            pushed.append(solved)
        if stiff <= 0:
            break
        if torque is not None:
            rotation = (torque + free) / stiff
        changed = False
        for each, solved in zip(parts, pushed, strict=True):
            each.pressure[:] = 0.0
            each.pressure[each.touching] = solved @ [rotation, -1.0]
            overlap = each.arm * rotation - each.gap - each.influence @ each.pressure
            touching = np.where(each.touching, each.pressure > 0, overlap > 0)
            changed = changed or bool((touching != each.touching).any())
            each.touching = touching
        if not changed:
            return rotation
    raise DidNotConvergeError(
        f"no pressure along the flanks that balances the torque was found in {_STEPS} steps"
    )
