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
from dataclasses import dataclass
from typing import TYPE_CHECKING, Final

import numpy as np

from lostmotion.errors import DidNotConvergeError
from lostmotion.laws.contact import LEAST_LOGARITHM, johnson_scale
from lostmotion.laws.cycloid.bodies import flexibility_with_second
from lostmotion.laws.cycloid.envelope import place_on_ring, second_contacts, second_radius
from lostmotion.laws.cycloid.envelope_contact import flank_moments, johnson_depth
from lostmotion.laws.cycloid.geometry import arms, contact_radius, normals, pin_angles

if TYPE_CHECKING:
    import numpy.typing as npt

    from lostmotion.laws.cycloid.bodies import Body
    from lostmotion.laws.cycloid.contact import Flanks
    from lostmotion.laws.cycloid.geometry import Stage
    from lostmotion.spatial import Floats

    Complexes = npt.NDArray[np.complex128]

# Reference load per width of the most loaded lobe without the second branch, over E* and the radius
# of the lobes: 100 N/mm on steel lobes of 3.5 mm.
REFERENCE_LOAD: Final = 2.5e-4
# Distance, over the sum of the half-widths, that two coinciding contacts count as.
_MERGED: Final = math.exp(-0.5) / 2
# Distances, over that sum, below which they are a single contact, because their equations are
# nearly dependent; the later ones where these fail.
_SAME: Final = (0.1, 0.3, 1.0)
# Distance from a contact of the second branch, over the pitch, within which one of the first branch
# takes part of its force even without its own.
_BESIDE: Final = 1 / 16
# Smallest widening over the junction with which the contact along the flank is solved.
_WIDER: Final = 1.02


def reduced_flexibility(
    stage: Stage, bodies: tuple[Body, ...], flanks: Flanks, crank: Floats
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
    stage: Stage, bodies: tuple[Body, ...], flanks: Flanks, crank: float
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


@functools.lru_cache(maxsize=256)
def _contacts(stage: Stage, crank: float, same: float) -> _Contacts:
    """Return the contacts, those of the second branch farther than `same` times the half-widths
    from those of the first one.
    """
    second = second_contacts(stage, [crank])[0]
    second = second[np.isfinite(second)]
    n = stage.pins
    theta = np.append(pin_angles(stage, np.array([crank]))[0], -stage.lobes * second)
    theta = np.asarray(np.angle(np.exp(1j * theta)))
    arm = arms(stage, theta)
    radius = np.append(contact_radius(stage, theta[:n]), second_radius(stage, second))
    half = np.sqrt(8 / math.pi * _reference_torque(stage) * np.abs(arm) / (arm @ arm) * radius)
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


def _reference_torque(stage: Stage) -> float:
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
    near = np.log(np.maximum(depth / _apart(given.places, given.half), 1.0)) * (
        1 - np.eye(len(arm))
    )
    load = _reference_torque(stage) * np.maximum(arm, 0.0) / (arm @ arm)
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


def _reduced_beyond(
    stage: Stage, bodies: tuple[Body, ...], flanks: Flanks, crank: float, same: float
) -> tuple[Floats, Floats, Floats]:
    """Return `_reduced` with contacts of the second branch that are farther than `same` times the
    half-widths from those of the first one.
    """
    given = _contacts(stage, crank, same)
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
    torque = flanks.modulus * flanks.width * _reference_torque(stage)
    # The law of the contact ends at the depth of Johnson's law for `local`: within it the modulus
    # is that of the contact, beyond that of the body.
    depth = johnson_depth(stage)
    local = np.append(radius[:n], np.full(len(second), depth * math.e / 2))
    beyond = -np.diag(np.log(local / radius))
    apart = _apart(places, half)
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
            + plane * (beyond - _merging(places, half) - near)
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


def _apart(places: Complexes, half: Floats) -> Floats:
    """Return the distances (m) that contacts with half-widths (contact,), m, count as; on the
    diagonal one.
    """
    wide = np.hypot(np.abs(places[:, None] - places), _MERGED * (half[:, None] + half))
    np.fill_diagonal(wide, 1.0)
    return np.asarray(wide)


def _merging(places: Complexes, half: Floats) -> Floats:
    """Return by how much the logarithm of the distance between contacts grows because of their
    half-widths (contact,), m: zero on the diagonal.
    """
    apart = np.abs(places[:, None] - places)
    np.fill_diagonal(apart, 1.0)
    return np.asarray(np.log(_apart(places, half) / apart))


def _equilibrium(
    torque: float, arm: Floats, soft: float, scale: Floats, moved: Floats, lever: float
) -> Floats:
    """Return the force of every contact (N) under a torque (N m) with a rigid eccentric. Raises
    DidNotConvergeError.
    """
    from lostmotion.laws.cycloid import contact_kernel as kernel
    from lostmotion.laws.cycloid import elastic_kernel

    count = len(arm)
    out, forces = np.empty((1, kernel.COLUMNS)), np.empty((1, count))
    one = np.ones((1, count))
    both = np.ascontiguousarray(np.broadcast_to(moved, (2, 1, count, count)))
    contacts = (
        0 * one,
        arm[None] / lever,
        soft * one,
        scale[None],
        np.inf * one,
        np.zeros((1, 1, count)),
    )
    elastic_kernel.solve_cases(
        0,
        1,
        kernel.LOGARITHMIC,
        lever,
        0.0,
        np.array([torque]),
        *contacts,
        np.array([np.inf]),
        both,
        out,
        forces,
    )
    if not np.isfinite(out[0, kernel.ROTATION]):
        raise DidNotConvergeError(
            "no equilibrium of the contacts of both branches was found under the reference load"
        )
    return np.asarray(forces[0])
