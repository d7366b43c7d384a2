"""Deformation of a solid cycloidal disc on its hub, or of an envelope ring in its housing, by
forces at contacts: the exact profile, not a circle.

A force on the profile is Flamant's solution of the half-plane whose edge is the tangent there. Its
tractions on the true, curved profile are small and smooth, and are cancelled by point forces
(Kelvin's solution) off the profile and beyond the fixed circle: method of fundamental solutions,
with strengths by least squares. Profile, points and point forces repeat with the lobes. So the
equations of a discrete Fourier transform over the lobes are independent and small. Small
displacements, linear material. Accurate to about 0.1 % of the rotation; the error shows in
displacements that are not reciprocal.

A ring surrounds the force, so the cut of Flamant's logarithm would cross it. Its logarithm has a
second pole at the ring's centre, with a dislocation that leaves the displacement single-valued;
both lie in the hole of the ring, and their tractions are cancelled with the others.

Source: N. Muskhelishvili, Some Basic Problems of the Mathematical Theory of Elasticity, 1953,
sections 57 and 93 (potentials of a force in the plane and on its edge), 38 (many-valued
displacements); G. Fairweather, A. Karageorghis, Adv. Comput. Math. 9 (1998) 69 (the method).
"""

from __future__ import annotations

import functools
import math
from dataclasses import dataclass
from typing import TYPE_CHECKING, Final

import numpy as np

from lostmotion.errors import DidNotConvergeError
from lostmotion.laws.cycloid.envelope import junction, ring_of_second_branch, second_radius
from lostmotion.laws.cycloid.geometry import contact_radius, flank, normals, pin_angles
from lostmotion.laws.cycloid.ring import ring_root_radius

if TYPE_CHECKING:
    from collections.abc import Callable

    import numpy.typing as npt

    from lostmotion.laws.annulus import Annulus
    from lostmotion.laws.cycloid.stage import Part, Stage
    from lostmotion.spatial import Floats

    Complexes = npt.NDArray[np.complex128]

# Point forces per lobe outside the flank, the later ones for sharp flanks and small pins; points of
# the flank per force, and distance of a force from the flank over the spacing.
_DENSITIES: Final = (24, 48, 96)
_POINTS: Final = 3
_OFF: Final = 2.0
# Largest distance of a force from the flank, over the radius of the valley.
_IN_VALLEY: Final = 0.6
# Least and largest number of forces around the fixed circle, and their number per length of the
# thinnest wall between it and the profile.
_HUB: Final = 64
_MOST: Final = 1000
_PER_WALL: Final = 4
# Unit of length over the radius of the rim; logarithms of a unit circle would make the equations
# singular.
_UNIT: Final = 3.0
# Step of the parameter of a pitch, for the ring's normal.
_STEP: Final = 1e-5
# Singular values below this share of the largest are omitted, with columns of unit length: nearly
# dependent forces stay small.
_RANK: Final = 1e-11
# Difference between a displacement and its reciprocal one, over the largest displacement: below
# which no more forces are tried, and largest one.
_GOAL: Final = 1e-3
_ASYMMETRY: Final = 1e-2
# Distance, in units of length, within which a point is that of the force.
_AT_FORCE: Final = 1e-7


@dataclass(frozen=True, slots=True)
class _Lobe:
    """Points and point forces of one of `count` lobes, in units of length: `points` with outward
    normals, the first `rim` of them on the profile.
    """

    points: Complexes
    normals: Complexes
    rim: int
    forces: Complexes
    unit: float
    count: int


def contact_flexibility(
    stage: Stage, body: Annulus, crank: float, part: Part = "planet", second: Floats | None = None
) -> Floats:
    """Return the displacements (m/N) of a wheel along contact i under a unit force at contact j,
    symmetric, with a fixed circle that does not move.

    stage   with a disc that has the lobes; for a ring with envelope lobes
    body    its material, width and fixed radius, which must be at least a tenth of the disc's; the
            loaded radius is not used
    crank   crank angle, rad
    second  parameters (contact,) of the disc's flank at contacts of the second branch, rad, which
            follow the N of the first branch

    Johnson's law of approach includes the wheel down to the depth 2 Req exp((1 + nu')/2 - 1); the
    diagonal is what it does not include. Raises DidNotConvergeError where the profile is too sharp.
    """
    for density in _DENSITIES:
        out = _attempt(stage, body, crank, density, part, second)
        error = float(np.abs(out - out.T).max() / np.abs(out).max())
        if error < _GOAL:
            break
    if not error < _ASYMMETRY:
        raise DidNotConvergeError(
            "the flank of this disc is too sharp for its deformation to be resolved: take "
            "larger pins or a smaller eccentricity"
        )
    return np.asarray((out + out.T) / 2)


def _attempt(
    stage: Stage,
    body: Annulus,
    crank: float,
    density: int,
    part: Part = "planet",
    second: Floats | None = None,
) -> Floats:
    """Return the displacements (m/N) along contact i under a unit force at contact j, with this
    number of point forces per lobe.
    """
    lobe, solve = _prepared(stage, body.fixed, body.kolosov, density, part)
    touch, into, radius = _contacts(stage, crank, part, np.zeros(0) if second is None else second)
    touch = touch / lobe.unit
    about_centre = part == "ring"
    around = np.exp(2j * math.pi * np.arange(lobe.count) / lobe.count)
    points, along = (around[:, None] * each for each in (lobe.points, lobe.normals))
    rim, fixed = points[:, : lobe.rim, None], points[:, lobe.rim :, None]
    pulled = _flamant_traction(rim, along[:, : lobe.rim, None], touch, into)
    if about_centre:
        pulled = pulled + _dislocation_traction(body.kolosov, rim, along[:, : lobe.rim, None], into)
    moved = _flamant_displacement(body.kolosov, fixed, touch, into, fixed if about_centre else None)
    wanted = -np.concatenate([pulled, moved], axis=1) * around.conj()[:, None, None]
    strength = around[:, None, None] * solve(wanted)
    forces = (around[:, None] * lobe.forces).ravel()
    smooth = _kelvin_displacement(
        body.kolosov, touch[:, None], forces, strength.reshape(len(forces), -1)
    )
    # Off the diagonal, the displacement of the surface; on it, that of the depth which the law of
    # the contact includes, in the half-plane.
    depth = 2 * radius * math.exp((1 + body.plane_nu) / 2 - 1) / lobe.unit
    at = touch[:, None] + np.diag(depth * into)
    whole = (
        _flamant_displacement(
            body.kolosov, at, touch, into, touch[:, None] if about_centre else None
        )
        + smooth
    )
    return np.asarray(
        (whole * into[:, None].conj()).real * (1 + body.nu) / (body.young * body.width)
    )


def _contacts(
    stage: Stage, crank: float, part: Part, second: Floats
) -> tuple[Complexes, Complexes, Floats]:
    """Return places (m), unit vectors into the wheel and equivalent radii (m) of all contacts, in
    the wheel's own axes about its centre.
    """
    theta = pin_angles(stage, np.array([crank]))[0]
    outward = normals(stage, theta) @ np.array([1, 1j])
    place = stage.ring_radius * np.exp(1j * theta) - stage.eccentricity - stage.pin_radius * outward
    # from the line of centres to the disc's own axes
    turn = np.exp(1j * crank * (1 + 1 / stage.lobes))
    of_second, away = (each @ np.array([1, 1j]) for each in flank(stage, second))
    touch, normal = np.append(place * turn, of_second), np.append(outward * turn, away)
    radius = np.append(contact_radius(stage, theta), second_radius(stage, second))
    if part == "planet":
        return touch, -normal, radius
    back = np.exp(-1j * crank / stage.lobes)
    return stage.eccentricity * np.exp(1j * crank) + touch * back, normal * back, radius


@functools.lru_cache(maxsize=16)
def _prepared(
    stage: Stage, fixed: float, kolosov: float, density: int, part: Part
) -> tuple[_Lobe, Callable[[Complexes], Complexes]]:
    """Return points and point forces of a lobe, and the function from wanted conditions to
    strengths, both (lobe, ..., load) in each lobe's axes.
    """
    lobe = _lobe(stage, fixed, density, part)
    count = lobe.count
    around = np.exp(2j * math.pi * np.arange(count) / count)
    points, along = (
        (around[:, None] * each).ravel()[:, None] for each in (lobe.points, lobe.normals)
    )
    block = np.empty((count, len(lobe.points), 2, len(lobe.forces), 2))
    for k, strength in enumerate((1.0, 1j)):
        moved = _kelvin_displacement(kolosov, points, lobe.forces, None, strength).reshape(
            count, len(lobe.points), -1
        )
        pulled = _kelvin_traction(kolosov, points, along, lobe.forces, strength).reshape(
            count, len(lobe.points), -1
        )
        both = (
            np.concatenate([pulled[:, : lobe.rim], moved[:, lobe.rim :]], axis=1)
            * around.conj()[:, None, None]
        )
        block[:, :, 0, :, k], block[:, :, 1, :, k] = both.real, both.imag
    # a fixed circle of any size must neither move nor turn
    held = np.full(len(lobe.points) - lobe.rim, (stage.ring_radius / fixed) ** 2)
    weight = np.repeat(np.concatenate([np.abs(np.gradient(lobe.points[: lobe.rim])), held]), 2)
    harmonics = (
        np.fft.rfft(block.reshape(count, 2 * len(lobe.points), 2 * len(lobe.forces)), axis=0)
        * weight[:, None]
    )
    size = np.sqrt((np.abs(harmonics) ** 2).sum(axis=1))[:, None]
    inverse = np.linalg.pinv(harmonics / size, rcond=_RANK)

    def solve(wanted: Complexes) -> Complexes:
        rows = np.stack([wanted.real, wanted.imag], axis=2).reshape(count, len(weight), -1)
        answer = inverse @ (np.fft.rfft(rows, axis=0) * weight[:, None])
        strength = np.fft.irfft(answer / size.transpose(0, 2, 1), count, axis=0)
        pairs = strength.reshape(count, len(lobe.forces), 2, -1)
        return np.asarray(pairs[:, :, 0] + 1j * pairs[:, :, 1])

    return lobe, solve


def _lobe(stage: Stage, fixed: float, density: int, part: Part) -> _Lobe:
    """Return points and point forces of one lobe, from valley to valley or from root to root, and
    of its share of the fixed circle.
    """
    unit = _UNIT * stage.ring_radius
    ring = part == "ring"
    count = stage.pins if ring else stage.lobes
    pitch = 2 * math.pi / count
    along = np.linspace(-1.0, 1.0, 20 * _POINTS * density + 1)
    fine, away = _profile(stage, part, along)
    length = np.concatenate([[0.0], np.cumsum(np.abs(np.diff(fine)))])
    if ring:
        wall = fixed - ring_root_radius(stage)
        valley = float(1 / np.gradient(np.unwrap(np.angle(away)), length).max())
    else:
        wall = stage.tip_radius - 2 * stage.eccentricity - fixed
        valley = stage.pin_radius

    def of_profile(number: int) -> tuple[Complexes, Complexes]:
        at = np.interp(length[-1] * (np.arange(number) + 0.5) / number, length, along)
        point, normal = _profile(stage, part, at)
        return point / unit, normal

    rim, outward = of_profile(_POINTS * density)
    near, off = of_profile(density)
    forces = near + off * min(_OFF * length[-1] / density, _IN_VALLEY * valley) / unit
    inside = math.ceil(max(_HUB, min(_PER_WALL * 2 * math.pi * fixed / wall, _MOST)) / count)
    around = np.exp(1j * pitch * (np.arange(inside) + 0.5) / inside)
    on_circle = np.exp(1j * pitch * (np.arange(_POINTS * inside) + 0.5) / (_POINTS * inside))
    beyond = 1 + _OFF * pitch / inside if ring else max(1 - _OFF * pitch / inside, 0.3)
    points = np.concatenate([rim, fixed / unit * on_circle])
    directions = np.concatenate([outward, on_circle if ring else -on_circle])
    return _Lobe(
        points,
        directions,
        len(rim),
        np.concatenate([forces, beyond * fixed / unit * around]),
        unit,
        count,
    )


def _profile(stage: Stage, part: Part, at: Floats) -> tuple[Complexes, Complexes]:
    """Return points of one pitch, m, and unit normals out of the wheel, at parameters from -1 to 1:
    between tips of the disc or roots of the ring.
    """
    if part == "planet":
        point, normal = (
            each @ np.array([1, 1j]) for each in flank(stage, at * math.pi / stage.lobes)
        )
        return point, normal
    point = _ring_points(stage, at)
    normal = 1j * (_ring_points(stage, at + _STEP) - _ring_points(stage, at - _STEP))
    return point, normal / np.abs(normal)


def _ring_points(stage: Stage, at: Floats) -> Complexes:
    """Return points (m) of an envelope ring's pitch: up to 1/2 of either side the arc of the pin,
    then the second branch.
    """
    off, start = np.abs(at), junction(stage)
    turn = 2 * math.asin(stage.shortening) * off
    arc = stage.ring_radius - stage.pin_radius * np.exp(-1j * turn)
    cut = ring_of_second_branch(
        stage, np.maximum(start + (2 * off - 1) * (math.pi / stage.lobes - start), start)
    ) @ np.array([1, 1j])
    half = np.where(off < 1 / 2, arc, cut)
    return np.asarray(np.where(at < 0, half.conj(), half))


def _kelvin_displacement(
    kolosov: float,
    z: Complexes,
    at: Complexes,
    strengths: Complexes | None,
    strength: complex = 1.0,
) -> Complexes:
    """Return 2 G times the displacement at points z (point, 1) of forces in the plane: of each
    (point, force), or of all (point, load).
    """
    w = z - at
    direct, conjugate = (
        -kolosov * np.log(np.abs(w)) / (math.pi * (1 + kolosov)),
        w / w.conj() / (2 * math.pi * (1 + kolosov)),
    )
    if strengths is None:
        return np.asarray(direct * strength + conjugate * np.conj(strength))
    return np.asarray(direct @ strengths + conjugate @ strengths.conj())


def _kelvin_traction(
    kolosov: float, z: Complexes, normal: Complexes, at: Complexes, strength: complex
) -> Complexes:
    """Return the traction (point, force) at points z with normals (point, 1) of forces in the
    plane.
    """
    w = z - at
    c = -strength / (2 * math.pi * (1 + kolosov))
    return np.asarray(
        2 * normal * (c / w).real + normal.conj() * (w * (c / w**2).conj() + kolosov * c / w.conj())
    )


def _flamant_displacement(
    kolosov: float, z: Complexes, at: Complexes, force: Complexes, centre: Complexes | None = None
) -> Complexes:
    """Return 2 G times displacement at points z of a force on the edge of a half-plane along its
    inward normal.

    centre  places about the ring's centre, for the dislocation there; None for a disc, behind whose
            edge the logarithm has its cut
    """
    w = _from_force(z, at, force)
    c = -force / (2 * math.pi)
    if centre is None:
        logarithm, closing = np.log(w * force.conj()), np.zeros_like(c)
    else:
        logarithm, a = np.log(w / centre), _dislocation(kolosov, force)
        closing = (c * (kolosov + 1) + a * (kolosov - 1)) * np.log(np.abs(centre)) - centre * (
            a / centre
        ).conj()
    return np.asarray(kolosov * c * logarithm - w * (c / w).conj() + c * logarithm.conj() + closing)


def _dislocation(kolosov: float, force: Complexes) -> Complexes:
    """Return the strength of the dislocation that closes Flamant's displacement around a ring."""
    return force * (kolosov - 1) / (2 * math.pi * (kolosov + 1))


def _dislocation_traction(
    kolosov: float, z: Complexes, normal: Complexes, force: Complexes
) -> Complexes:
    """Return the traction at points z with these normals of the dislocation at the ring's
    centre.
    """
    a = _dislocation(kolosov, force)
    return np.asarray(
        2 * normal * (a / z).real + normal.conj() * (z * (a / z**2).conj() - a / z.conj())
    )


def _flamant_traction(
    z: Complexes, normal: Complexes, at: Complexes, force: Complexes
) -> Complexes:
    """Return the traction at points z with these normals of the same force."""
    w = _from_force(z, at, force)
    c = -force / (2 * math.pi)
    return np.asarray(
        2 * normal * (c / w).real + normal.conj() * (w * (c / w**2).conj() + c / w.conj())
    )


def _from_force(z: Complexes, at: Complexes, force: Complexes) -> Complexes:
    """Return the places of points z from that of a force; one at the force is moved along the edge,
    where the traction vanishes.
    """
    w = z - at
    return np.asarray(np.where(np.abs(w) > _AT_FORCE, w, 1j * _AT_FORCE * force))
