"""Deformation of a solid cycloidal disc on its hub by forces at its contacts: the exact flank, not a circle in its place.

A force on the flank is Flamant's solution of the half-plane whose edge is the tangent there. Its tractions on the true, curved flank are small and
smooth, and are cancelled by point forces (Kelvin's solution) outside the disc and inside its hub: method of fundamental solutions, with strengths by
least squares. Disc, points and point forces repeat with the lobes. So the equations of a discrete Fourier transform over the lobes are independent
and small. Small displacements, linear material. Accurate to about 0.1 % of the rotation; the error shows in displacements that are not reciprocal.

Source: N. Muskhelishvili, Some Basic Problems of the Mathematical Theory of Elasticity, 1953, sections 57 and 93 (potentials of a force in the plane
and on its edge); G. Fairweather, A. Karageorghis, Adv. Comput. Math. 9 (1998) 69 (the method).
"""

from __future__ import annotations

import functools
import math
from dataclasses import dataclass
from typing import TYPE_CHECKING, Final

import numpy as np

from lostmotion.errors import DidNotConvergeError
from lostmotion.laws.cycloid.geometry import contact_radius, flank, normals, pin_angles

if TYPE_CHECKING:
    from collections.abc import Callable

    import numpy.typing as npt

    from lostmotion.laws.annulus import Annulus
    from lostmotion.laws.cycloid.geometry import Stage
    from lostmotion.spatial import Floats

    Complexes = npt.NDArray[np.complex128]

# Point forces per lobe outside the flank, the later ones for sharp flanks and small pins; points of the flank per force, and distance of a force from
# the flank over the spacing.
_DENSITIES: Final = (24, 48, 96)
_POINTS: Final = 3
_OFF: Final = 2.0
# Largest distance of a force from the flank, over the radius of a pin.
_IN_VALLEY: Final = 0.6
# Least and largest number of forces around the hub, and their number per length of the thinnest wall between hub and flank.
_HUB: Final = 64
_MOST: Final = 1000
_PER_WALL: Final = 4
# Unit of length over the radius of the rim; logarithms of a unit circle would make the equations singular.
_UNIT: Final = 3.0
# Singular values below this share of the largest are omitted, with columns of unit length: nearly dependent forces stay small.
_RANK: Final = 1e-11
# Difference between a displacement and its reciprocal one, over the largest displacement: below which no more forces are tried, and largest one.
_GOAL: Final = 1e-3
_ASYMMETRY: Final = 1e-2
# Distance, in units of length, within which a point is that of the force.
_AT_FORCE: Final = 1e-7


@dataclass(frozen=True, slots=True)
class _Lobe:
    """Points and point forces of one lobe, in units of length: `points` with outward normals, of which the first `rim` are on the flank."""

    points: Complexes
    normals: Complexes
    rim: int
    forces: Complexes
    unit: float


def contact_flexibility(stage: Stage, body: Annulus, crank: float) -> Floats:
    """Return the displacements (m/N) of the disc along contact i under a unit force at contact j: (N, N), symmetric, with a fixed hub.

    stage  with a disc that has the lobes
    body   its material, width and fixed radius, which must be at least a tenth of the disc's; the loaded radius is not used
    crank  crank angle, rad

    Johnson's law of approach includes the disc down to the depth 2 Req exp((1 + nu')/2 - 1); the diagonal is what it does not include. Raises
    DidNotConvergeError where the flank is too sharp.
    """
    for density in _DENSITIES:
        out = _attempt(stage, body, crank, density)
        error = float(np.abs(out - out.T).max() / np.abs(out).max())
        if error < _GOAL:
            break
    if not error < _ASYMMETRY:
        raise DidNotConvergeError(
            "the flank of this disc is too sharp for its deformation to be resolved: take larger pins or a smaller eccentricity"
        )
    return np.asarray((out + out.T) / 2)


def _attempt(stage: Stage, body: Annulus, crank: float, density: int) -> Floats:
    """Return the displacements (m/N) along contact i under a unit force at contact j, with this number of point forces per lobe."""
    lobe, solve = _prepared(stage, body.fixed, body.kolosov, density)
    theta = pin_angles(stage, np.array([crank]))[0]
    outward = normals(stage, theta) @ np.array([1, 1j])
    touch = (stage.ring_radius * np.exp(1j * theta) - stage.eccentricity - stage.pin_radius * outward) / lobe.unit
    turn = np.exp(1j * crank * (1 + 1 / stage.lobes))  # from the line of centres to the disc's own axes
    outward, touch = outward * turn, touch * turn
    around = np.exp(2j * math.pi * np.arange(stage.lobes) / stage.lobes)
    points, along = (around[:, None] * each for each in (lobe.points, lobe.normals))
    pulled = _flamant_traction(points[:, : lobe.rim, None], along[:, : lobe.rim, None], touch, -outward)
    moved = _flamant_displacement(body.kolosov, points[:, lobe.rim :, None], touch, -outward)
    wanted = -np.concatenate([pulled, moved], axis=1) * around.conj()[:, None, None]
    strength = around[:, None, None] * solve(wanted)
    forces = (around[:, None] * lobe.forces).ravel()
    smooth = _kelvin_displacement(body.kolosov, touch[:, None], forces, strength.reshape(len(forces), -1))
    # Off the diagonal, the displacement of the surface; on it, that of the depth which the law of the contact includes, in the half-plane.
    depth = 2 * contact_radius(stage, theta) * math.exp((1 + body.plane_nu) / 2 - 1) / lobe.unit
    at = touch[:, None] - np.diag(depth * outward)
    whole = _flamant_displacement(body.kolosov, at, touch, -outward) + smooth
    return np.asarray((whole * -outward[:, None].conj()).real * (1 + body.nu) / (body.young * body.width))


@functools.lru_cache(maxsize=16)
def _prepared(stage: Stage, hub: float, kolosov: float, density: int) -> tuple[_Lobe, Callable[[Complexes], Complexes]]:
    """Return points and point forces of a lobe, and the function from wanted conditions to strengths, both (lobe, ..., load) in each lobe's axes."""
    lobe = _lobe(stage, hub, density)
    count = stage.lobes
    around = np.exp(2j * math.pi * np.arange(count) / count)
    points, along = ((around[:, None] * each).ravel()[:, None] for each in (lobe.points, lobe.normals))
    block = np.empty((count, len(lobe.points), 2, len(lobe.forces), 2))
    for k, strength in enumerate((1.0, 1j)):
        moved = _kelvin_displacement(kolosov, points, lobe.forces, None, strength).reshape(count, len(lobe.points), -1)
        pulled = _kelvin_traction(kolosov, points, along, lobe.forces, strength).reshape(count, len(lobe.points), -1)
        both = np.concatenate([pulled[:, : lobe.rim], moved[:, lobe.rim :]], axis=1) * around.conj()[:, None, None]
        block[:, :, 0, :, k], block[:, :, 1, :, k] = both.real, both.imag
    # a hub of any size must neither move nor turn
    held = np.full(len(lobe.points) - lobe.rim, (stage.ring_radius / hub) ** 2)
    weight = np.repeat(np.concatenate([np.abs(np.gradient(lobe.points[: lobe.rim])), held]), 2)
    harmonics = np.fft.rfft(block.reshape(count, 2 * len(lobe.points), 2 * len(lobe.forces)), axis=0) * weight[:, None]
    size = np.sqrt((np.abs(harmonics) ** 2).sum(axis=1))[:, None]
    inverse = np.linalg.pinv(harmonics / size, rcond=_RANK)

    def solve(wanted: Complexes) -> Complexes:
        rows = np.stack([wanted.real, wanted.imag], axis=2).reshape(count, len(weight), -1)
        answer = inverse @ (np.fft.rfft(rows, axis=0) * weight[:, None])
        strength = np.fft.irfft(answer / size.transpose(0, 2, 1), count, axis=0)
        pairs = strength.reshape(count, len(lobe.forces), 2, -1)
        return np.asarray(pairs[:, :, 0] + 1j * pairs[:, :, 1])

    return lobe, solve


def _lobe(stage: Stage, hub: float, density: int) -> _Lobe:
    """Return points and point forces of one lobe, from valley to valley, and of its share of the hub."""
    unit = _UNIT * stage.ring_radius
    pitch = 2 * math.pi / stage.lobes
    fine = np.linspace(0.0, pitch, 20 * _POINTS * density + 1)
    length = np.concatenate([[0.0], np.cumsum(np.abs(np.diff(flank(stage, fine)[0] @ np.array([1, 1j]))))])

    def of_flank(count: int) -> tuple[Complexes, Complexes]:
        at = np.interp(length[-1] * (np.arange(count) + 0.5) / count, length, fine)
        point, normal = (each @ np.array([1, 1j]) for each in flank(stage, at))
        return point / unit, normal

    rim, outward = of_flank(_POINTS * density)
    near, away = of_flank(density)
    forces = near + away * min(_OFF * length[-1] / density, _IN_VALLEY * stage.pin_radius) / unit
    wall = stage.tip_radius - 2 * stage.eccentricity - hub
    inside = math.ceil(max(_HUB, min(_PER_WALL * 2 * math.pi * hub / wall, _MOST)) / stage.lobes)
    around = np.exp(1j * pitch * (np.arange(inside) + 0.5) / inside)
    on_hub = np.exp(1j * pitch * (np.arange(_POINTS * inside) + 0.5) / (_POINTS * inside))
    within = max(1 - _OFF * pitch / inside, 0.3)
    points, directions = np.concatenate([rim, hub / unit * on_hub]), np.concatenate([outward, -on_hub])
    return _Lobe(points, directions, len(rim), np.concatenate([forces, within * hub / unit * around]), unit)


def _kelvin_displacement(kolosov: float, z: Complexes, at: Complexes, strengths: Complexes | None, strength: complex = 1.0) -> Complexes:
    """Return 2 G times the displacement at points z (point, 1) of forces in the plane: of each (point, force), or of all (point, load)."""
    w = z - at
    direct, conjugate = -kolosov * np.log(np.abs(w)) / (math.pi * (1 + kolosov)), w / w.conj() / (2 * math.pi * (1 + kolosov))
    if strengths is None:
        return np.asarray(direct * strength + conjugate * np.conj(strength))
    return np.asarray(direct @ strengths + conjugate @ strengths.conj())


def _kelvin_traction(kolosov: float, z: Complexes, normal: Complexes, at: Complexes, strength: complex) -> Complexes:
    """Return the traction (point, force) at points z with normals (point, 1) of forces in the plane."""
    w = z - at
    c = -strength / (2 * math.pi * (1 + kolosov))
    return np.asarray(2 * normal * (c / w).real + normal.conj() * (w * (c / w**2).conj() + kolosov * c / w.conj()))


def _flamant_displacement(kolosov: float, z: Complexes, at: Complexes, force: Complexes) -> Complexes:
    """Return 2 G times displacement at points z of a force on the edge of a half-plane along its inward normal."""
    w = _from_force(z, at, force)
    c = -force / (2 * math.pi)
    logarithm = np.log(w * force.conj())  # its cut is outside the body
    return np.asarray(kolosov * c * logarithm - w * (c / w).conj() + c * logarithm.conj())


def _flamant_traction(z: Complexes, normal: Complexes, at: Complexes, force: Complexes) -> Complexes:
    """Return the traction at points z with these normals of the same force."""
    w = _from_force(z, at, force)
    c = -force / (2 * math.pi)
    return np.asarray(2 * normal * (c / w).real + normal.conj() * (w * (c / w**2).conj() + c / w.conj()))


def _from_force(z: Complexes, at: Complexes, force: Complexes) -> Complexes:
    """Return the places of points z from that of a force; one at the force is moved along the edge, where the traction vanishes."""
    w = z - at
    return np.asarray(np.where(np.abs(w) > _AT_FORCE, w, 1j * _AT_FORCE * force))
