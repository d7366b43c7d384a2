"""Contacts of both branches by flank: two contacts apart, two that merge, or one wide contact over
the junction of the branches.
"""

from __future__ import annotations

import functools
import math
from dataclasses import dataclass
from typing import TYPE_CHECKING, Final

import numpy as np

from lostmotion.errors import DidNotConvergeError
from lostmotion.laws.contact import LEAST_LOGARITHM
from lostmotion.laws.cycloid.envelope import place_on_ring, second_contacts, second_radius
from lostmotion.laws.cycloid.envelope_contact import flank_moments, johnson_depth
from lostmotion.laws.cycloid.geometry import arms, contact_radius, normals, pin_angles

if TYPE_CHECKING:
    import numpy.typing as npt

    from lostmotion.laws.cycloid.stage import Stage
    from lostmotion.spatial import Floats

    Complexes = npt.NDArray[np.complex128]

# Reference load per width of the most loaded lobe without the second branch, over E* and the radius
# of the lobes: 100 N/mm on steel lobes of 3.5 mm.
REFERENCE_LOAD: Final = 2.5e-4
# Distance, over the sum of the half-widths, that two coinciding contacts count as.
_MERGED: Final = math.exp(-0.5) / 2
# Smallest widening over the junction with which the contact along the flank is solved.
_WIDER: Final = 1.02


@dataclass(frozen=True, slots=True)
class _Contacts:
    """Contacts (contact,) of a stage at one crank angle, first those of the first branch.

    second  parameters of the disc's flank at those of the second branch, rad
    theta   of a pin with the same arm, rad; arm in m
    radius  equivalent radii, m; `merged` with the width over the junction
    half    half-widths under the reference load, m
    places  on the ring, m
    extra   (side, contact) added to the logarithm of each law, by the contact along the flank of
            those that reach over the junction
    """

    second: Floats
    theta: Floats
    arm: Floats
    radius: Floats
    merged: Floats
    half: Floats
    places: Complexes
    extra: Floats


def contacts_of_both(stage: Stage, crank: float, same: float) -> _Contacts:
    """Return the contacts, those of the second branch farther than `same` times the half-widths
    from those of the first one. Raises DidNotConvergeError.
    """
    found = _found(stage, crank, same)
    if isinstance(found, str):
        raise DidNotConvergeError(found)
    return found


@functools.lru_cache(maxsize=256)
def _found(stage: Stage, crank: float, same: float) -> _Contacts | str:
    """Return `contacts_of_both`, or why there are none: that is found as slowly as contacts are,
    and drawings of the same profile ask for it again.
    """
    try:
        return _contacts(stage, crank, same)
    except DidNotConvergeError as error:
        return str(error)


def _contacts(stage: Stage, crank: float, same: float) -> _Contacts:
    second = second_contacts(stage, [crank])[0]
    second = second[np.isfinite(second)]
    n = stage.pins
    theta = np.append(pin_angles(stage, np.array([crank]))[0], -stage.lobes * second)
    theta = np.asarray(np.angle(np.exp(1j * theta)))
    arm = arms(stage, theta)
    radius = np.append(contact_radius(stage, theta[:n]), second_radius(stage, second))
    half = np.sqrt(8 / math.pi * reference_torque(stage) * np.abs(arm) / (arm @ arm) * radius)
    first = stage.ring_radius * np.exp(1j * theta[:n]) - stage.pin_radius * (
        normals(stage, theta[:n]) @ np.array([1, 1j])
    )
    places = np.append(first * np.exp(1j * crank), place_on_ring(stage, second, crank))
    wide = _over_junction(stage, places, radius, half)
    half = half * wide
    apart = np.abs(places[n:, None] - places[:n])
    one = np.append(
        np.ones(n, dtype=bool), (apart > same * (half[n:, None] + half[:n])).all(axis=1)
    )
    second, theta, arm, radius, half, places, wide = (
        second[one[n:]],
        *(each[one] for each in (theta, arm, radius, half, places, wide)),
    )
    found = _Contacts(
        second, theta, arm, radius, radius * wide**2, half, places, np.zeros((2, len(theta)))
    )
    for side, sign in enumerate((1, -1)):
        found.extra[side] = _by_flank(
            stage, found, crank, np.flatnonzero((wide > _WIDER) & (sign * arm > 0)), sign
        )
    return found


def reference_torque(stage: Stage) -> float:
    """Return the torque of the reference load per width and modulus E* (m^2)."""
    return REFERENCE_LOAD * stage.pin_radius * stage.planet_pitch_radius * stage.pins / 4


def _by_flank(stage: Stage, given: _Contacts, crank: float, over: np.ndarray, sign: int) -> Floats:
    """Return what is added to the logarithms of the laws of all contacts (contact,), so that those
    `over` the junction carry as by their whole flank.

    On half-planes with a common depth: each flank with such a contact is turned as far as its
    contacts turn by their laws, under the reference load.
    """
    out = np.zeros(len(given.arm))
    depth, z = johnson_depth(stage), stage.lobes
    at = (given.places - stage.eccentricity * np.exp(1j * crank)) * np.exp(1j * crank / z)
    lobes = np.round((sign * np.angle(at) + math.pi / (2 * z)) * z / (2 * math.pi)).astype(int)
    law = np.log(math.pi * math.e * depth**2 / given.merged)
    arm = sign * given.arm
    near = np.log(np.maximum(depth / distances(given.places, given.half), 1.0)) * (
        1 - np.eye(len(arm))
    )
    load = reference_torque(stage) * np.maximum(arm, 0.0) / (arm @ arm)
    for k in over:
        mine = np.flatnonzero((lobes == lobes[k]) & (arm > 0))
        force, others = load[mine], 2 * near[np.ix_(mine, mine)]
        rotation = (
            float(
                force @ (force * (law[mine] - np.log(force)) + others @ force) / (force @ arm[mine])
            )
            / math.pi
        )
        force = (
            flank_moments(
                stage,
                sign * crank,
                int(lobes[k]),
                rotation,
                float(given.half[k]),
                depth,
                sign * given.theta[mine],
            )
            / arm[mine]
        )
        loaded = np.where(force > 0, force, 1.0)
        logarithm = np.maximum(
            (math.pi * rotation * arm[mine] - others @ force) / loaded, LEAST_LOGARITHM
        )
        touching = force > 0
        # By how much more each approaches per further load; otherwise several divisions of the load
        # between them are in equilibrium.
        stiffness = (np.diag(logarithm - 1) + others)[np.ix_(touching, touching)]
        if not (np.linalg.eigvalsh(stiffness) > 0).all():
            raise DidNotConvergeError(
                "two contacts at the junction of the branches of an envelope ring are too "
                "close to have forces of their own"
            )
        out[mine] = np.where(force > 0, logarithm - law[mine] + np.log(loaded), 0.0)
    return out


def _over_junction(stage: Stage, places: Complexes, radius: Floats, half: Floats) -> Floats:
    """Return by how many times contacts with half-widths (contact,), m, are wider because they
    reach over the junction of the branches.

    places  (contact,) on the ring, m, first those of the first branch; radius: their equivalent
            radii (contact,), m
    """
    n, turn = stage.pins, math.asin(stage.shortening)
    junction = stage.ring_radius - stage.pin_radius * np.exp(-1j * turn)
    folded = places * np.exp(-2j * math.pi / n * np.round(np.angle(places) * n / (2 * math.pi)))
    distance = np.abs(folded.real + 1j * np.abs(folded.imag) - junction)
    other = np.zeros(len(radius))
    other[n:] = 1 / contact_radius(stage, np.array(math.acos(stage.shortening)))
    total, change = 1 / radius + other, distance * (1 / radius - other) / 2
    wide = (np.sqrt(change**2 + 2 * total * half**2 / radius) - change) / total
    return np.asarray(np.where(half > distance, wide / np.maximum(half, np.finfo(float).tiny), 1.0))


def distances(places: Complexes, half: Floats) -> Floats:
    """Return the distances (m) that contacts with half-widths (contact,), m, count as; on the
    diagonal one.
    """
    wide = np.hypot(np.abs(places[:, None] - places), _MERGED * (half[:, None] + half))
    np.fill_diagonal(wide, 1.0)
    return np.asarray(wide)


def merging(places: Complexes, half: Floats) -> Floats:
    """Return by how much the logarithm of the distance between contacts grows because of their
    half-widths (contact,), m: zero on the diagonal.
    """
    apart = np.abs(places[:, None] - places)
    np.fill_diagonal(apart, 1.0)
    return np.asarray(np.log(distances(places, half) / apart))
