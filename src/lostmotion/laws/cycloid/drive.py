"""A cycloidal stage with its supports as springs: their stiffness, the forces on the crank, and the
equilibrium of each disc.

The eccentric's bearing stiffens with its load and is represented by its secant stiffness. In a
drive whose crankshafts carry the output (RV) the same bearings support the disc against
translation, as a single eccentric does, and against rotation, as output pins would. Valid for
static load and to first order in the gaps. The discs share the torque equally here; for the effect
of their differences see `cycloid.tolerances`.

Source: K = 1/sum(1/K_i) with K_ecc = k (e z)^2 and K_pins = k_w Rw^2 n_w/4 after M. Lehmann, TU
München 1976; the crankshafts by statics.
"""

from __future__ import annotations

import functools
import math
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Final

import numpy as np

from lostmotion.laws.cycloid.bodies import flexibility
from lostmotion.laws.cycloid.both_branches import reduced_flexibility
from lostmotion.laws.cycloid.contact import (
    Flanks,
    LoadSharing,
    Supports,
    load_sharing,
)
from lostmotion.laws.cycloid.geometry import first_contact_angle, gaps, pin_angles
from lostmotion.laws.cycloid.kept import recalled
from lostmotion.laws.cycloid.stage import Modification, Stage
from lostmotion.laws.rolling.radial import ROLLER_EXPONENT, element_angles, radial_shift

if TYPE_CHECKING:
    from collections.abc import Sequence

    from lostmotion.laws.cycloid.bodies import ElasticBody
    from lostmotion.spatial import Floats

# Number of crank angles within one pitch over which the ripple is averaged.
_RIPPLE: Final = 6
# Smallest arm, over the largest, of flanks that limit the free rotation. Flanks nearer to the line
# of centres push a disc aside when they interfere; only a rigid disc on a rigid eccentric would be
# stopped by them.
LEAST_ARM: Final = 0.1
# Share of a torque that counts as no torque.
_REST: Final = 0.01
# Forces of contacts, in number, that are computed and held at once.
_TOGETHER: Final = 2_000_000
# Number of crank angles over a turn, to average the forces on the crankshafts.
_ROUND: Final = 72


@dataclass(frozen=True, slots=True)
class EccentricSprings:
    """Stiffness of the eccentric, per disc and crankshaft: its bearing, and the shaft with its
    seats; infinite means rigid.

    bearing            stiffness of the bearing, N/m; used where `elements` is 0
    elements           number of rolling elements of the bearing, without clearance
    element_stiffness  K of one element, N/m^n (`rolling.roller_stiffness`), with its `exponent` n
    shaft              stiffness of shaft and seats, N/m
    cranks             number of crankshafts
    circle             radius of the circle of crankshafts that carry the output (RV), m; infinite
                       for one central eccentric

    Raises ValueError for impossible values.
    """

    bearing: float = math.inf
    elements: int = 0
    element_stiffness: float = math.inf
    exponent: float = ROLLER_EXPONENT
    shaft: float = math.inf
    cranks: int = 1
    circle: float = math.inf

    def __post_init__(self) -> None:
        """Refuse stiffnesses of zero or less, bearings with too few elements, and a single
        crankshaft off the centre.
        """
        if not (
            self.bearing > 0 and self.element_stiffness > 0 and self.shaft > 0 and self.circle > 0
        ):
            raise ValueError(
                "stiffness and circle of an eccentric must be above zero; infinite means rigid"
            )
        if self.elements and (self.elements < 3 or math.isinf(self.element_stiffness)):  # noqa: PLR2004 - two support one direction only
            raise ValueError("a rolling bearing needs three elements or more, and their stiffness")
        if self.cranks < 1 or (self.cranks == 1) != math.isinf(self.circle):
            raise ValueError(
                "one eccentric must be at the centre, two or more crankshafts on a circle"
            )

    def bearing_stiffness(self, force: float) -> float:
        """Return the secant stiffness (N/m) of one bearing under this force (N)."""
        if not self.elements:
            return self.bearing
        if force <= 0:
            return 0.0
        return force / _shift(self.elements, self.element_stiffness, self.exponent, force)

    def stiffness(self, force: float) -> float:
        """Return the stiffness (N/m) of bearing and shaft of one crank in series under this force
        (N).
        """
        bearing = self.bearing_stiffness(force)
        soft = (1 / bearing if bearing else math.inf) + 1 / self.shaft
        return 1 / soft if soft else math.inf


@functools.lru_cache(maxsize=1024)
def _shift(elements: int, stiffness: float, exponent: float, force: float) -> float:
    """Return the shift (m) of a bearing without clearance; all discs of a drive ask for it under
    the same forces.
    """
    return float(radial_shift(force, 0.0, stiffness, exponent, element_angles(elements)))


@dataclass(frozen=True, slots=True)
class OutputPinSprings:
    """Output pins that transmit the torque of the discs: `count` pins on the radius `circle` (m),
    each of `stiffness` (N/m) at the discs.
    """

    count: int
    circle: float
    stiffness: float = math.inf


@dataclass(frozen=True, slots=True)
class Drive:
    """A cycloidal stage with its supports.

    relief                profile modification
    discs                 number of discs, which share the torque equally
    output                output pins; None for crankshafts that carry the output
    disc_body, ring_body  None means rigid; otherwise the law of the flanks must be Johnson's, which
                          defines the depth of the bodies

    Raises ValueError for elastic bodies with another law.
    """

    stage: Stage
    flanks: Flanks
    relief: Modification = field(default_factory=Modification)
    discs: int = 1
    eccentric: EccentricSprings = field(default_factory=EccentricSprings)
    output: OutputPinSprings | None = None
    disc_body: ElasticBody | None = None
    ring_body: ElasticBody | None = None

    def __post_init__(self) -> None:
        """Refuse elastic bodies with another law than Johnson's."""
        if (self.disc_body or self.ring_body) and self.flanks.law != "johnson":
            raise ValueError(
                "elastic bodies need Johnson's law of approach, which defines their depth, "
                f"not {self.flanks.law!r}"
            )

    def bodies(self, crank: Floats) -> tuple[Floats | None, Floats | None, Floats | None]:
        """Return the displacement (side, crank, N, N) along contact i per force at contact j, m/N,
        of disc and ring; None where both are rigid.

        And, of an envelope ring on elastic bodies, `stiffening` and `pressed` of its contacts
        (crank, N) for `load_sharing`, otherwise None.
        """
        return _bodies(self, np.ascontiguousarray(crank, dtype=float).tobytes())


@functools.lru_cache(maxsize=16)
def _bodies(drive: Drive, crank: bytes) -> tuple[Floats | None, Floats | None, Floats | None]:
    parts = tuple(each for each in (drive.disc_body, drive.ring_body) if each is not None)
    if not parts:
        return None, None, None
    key = f"{drive.stage!r} {parts!r} {drive.flanks!r} {crank.hex()}"
    found = recalled(key, functools.partial(_flexibilities, drive, parts, np.frombuffer(crank)))
    return (*found, None, None) if len(found) == 1 else (found[0], found[1], found[2])


def _flexibilities(
    drive: Drive, parts: tuple[ElasticBody, ...], crank: Floats
) -> tuple[Floats, ...]:
    if drive.stage.kind == "lobe envelope":
        return reduced_flexibility(drive.stage, parts, drive.flanks, crank)
    return (
        np.asarray(
            np.sum(
                [flexibility(drive.stage, each, drive.flanks.width, crank) for each in parts],
                axis=0,
            )
        ),
    )


def crank_force_per_torque(drive: Drive) -> float:
    """Return the force (N) on the bearing of each crankshaft per N m on one disc, averaged over a
    turn: 1/(e z) for one central eccentric.

    For several crankshafts it is the vector sum of the reaction of the mesh, 1/(e z), equal for
    all, and of the torque's, 1/Rc, along the circle.
    """
    lever, circle = drive.stage.planet_pitch_radius, drive.eccentric.circle
    if math.isinf(circle):
        return 1 / lever
    around = np.cos(2 * math.pi * np.arange(_ROUND) / _ROUND)
    return (
        float(np.sqrt(lever**-2 + circle**-2 + 2 * around / (lever * circle)).mean())
        / drive.eccentric.cranks
    )


def play_per_crank_clearance(drive: Drive) -> float:
    """Return the play (rad) of the output per metre of diametral clearance in every crank bearing:
    1/(e z) for one central eccentric.

    By virtual work: every bearing moves by half of its clearance along its own force, in either
    direction. For several crankshafts this is an upper bound, reached under load.
    """
    return crank_force_per_torque(drive) * drive.eccentric.cranks


def crank_force(drive: Drive, torque: float) -> float:
    """Return the force (N) on the bearing of each crankshaft under a torque (N m) on one disc of
    the nominal stage, averaged over a pitch.

    Larger than `crank_force_per_torque` times the torque, because lobes also push slightly along
    the line of centres. Raises DidNotConvergeError.
    """
    return crank_forces(drive, (torque,))[0]


@functools.lru_cache(maxsize=256)
def crank_forces(drive: Drive, torque: tuple[float, ...]) -> tuple[float, ...]:
    """Return `crank_force` under each torque."""
    crank, per_torque = crank_angles_of_pitch(drive), crank_force_per_torque(drive)
    supports = _supports(drive, [abs(each) * per_torque for each in torque], rigid=False)
    bodies, stiffening, _ = drive.bodies(crank)
    answer = load_sharing(
        drive.stage,
        drive.flanks,
        torque,
        crank,
        nominal_gaps(drive, crank),
        supports,
        bodies=bodies,
        stiffening=stiffening,
    ).checked()
    return tuple(
        float(each.mean()) * per_torque * drive.stage.planet_pitch_radius
        for each in answer.bearing_force
    )


def loaded_disc(
    drive: Drive,
    torque: Floats | float,
    crank: Floats,
    gap: Floats,
    *,
    places: np.ndarray | None = None,
    rigid_eccentric: bool = False,
    threads: int = 1,
) -> LoadSharing:
    """Return the load sharing of one disc under its torque, with the bodies of disc and ring.

    torque  N m on the disc, one or (torque,), not zero
    crank   (crank,) crank angles, rad
    gap     (crank, draw, N) m
    places  (place,) numbers of crank angles, for which the gaps then are, as of `load_sharing`

    The bearing of the eccentric has its secant stiffness under its force in the nominal stage.
    Raises DidNotConvergeError.
    """
    torques = np.atleast_1d(torque).tolist()
    if drive.eccentric.elements and not rigid_eccentric:
        forces = crank_forces(drive, tuple(torques))
    else:
        forces = tuple(abs(each) * crank_force_per_torque(drive) for each in torques)
    supports = _supports(drive, forces, rigid=rigid_eccentric)
    bodies, stiffening, pressed = drive.bodies(crank)
    return load_sharing(
        drive.stage,
        drive.flanks,
        torques,
        crank,
        gap,
        supports,
        bodies=bodies,
        stiffening=stiffening,
        pressed=pressed,
        places=places,
        threads=threads,
    ).checked()


def rotations(
    drive: Drive,
    torque: Floats,
    crank: Floats,
    gap: Floats,
    *,
    places: np.ndarray | None = None,
    rigid_eccentric: bool = False,
    threads: int = 1,
) -> tuple[Floats, Floats]:
    """Return rotation (rad) and stiffness (N m/rad) of one disc under torques (torque,), N m:
    (torque, crank, draw). Arguments and errors as `loaded_disc`.
    """
    out = np.empty((2, len(torque), *gap.shape[:2]))
    together = max(1, _TOGETHER // gap.size)
    for first in range(0, len(torque), together):
        some = slice(first, first + together)
        found = loaded_disc(
            drive,
            torque[some],
            crank,
            gap,
            places=places,
            rigid_eccentric=rigid_eccentric,
            threads=threads,
        )
        out[0, some], out[1, some] = found.rotation, found.stiffness
    return out[0], out[1]


def rest_angle(
    drive: Drive,
    crank: Floats,
    gap: Floats,
    torque: float,
    *,
    rigid_eccentric: bool = False,
    threads: int = 1,
) -> Floats:
    """Return the angle (crank, draw), rad, at which a disc with interfering flanks rests without
    torque; NaN for a disc with play.

    gap     (crank, draw, N) m
    torque  N m, positive; the result is the mean of the angles under +- a hundredth of it

    Raises DidNotConvergeError where the interference is beyond the contact law, or its forces are
    10 000 times those of `torque`.
    """
    interfering = interferes(drive, crank, gap)
    chosen = np.flatnonzero(interfering.any(axis=0))
    out = np.full(interfering.shape, math.nan)
    if len(chosen):
        small = _REST * torque
        either, _ = rotations(
            drive,
            np.array([-small, small]),
            crank,
            gap[:, chosen],
            rigid_eccentric=rigid_eccentric,
            threads=threads,
        )
        out[:, chosen] = np.where(interfering[:, chosen], (either[0] + either[1]) / 2, math.nan)
    return out


def interferes(
    drive: Drive, crank: Floats, gap: Floats
) -> np.ndarray[tuple[int, ...], np.dtype[np.bool_]]:
    """Return a mask (crank, draw) of the gaps (crank, draw, N), m, with which the flanks of one
    disc interfere, so that it has no play.
    """
    theta = pin_angles(drive.stage, crank)[:, None]
    return (
        first_contact_angle(drive.stage, theta, gap, LEAST_ARM)
        + first_contact_angle(drive.stage, -theta, gap, LEAST_ARM)
        < 0
    )


def _supports(drive: Drive, forces: Sequence[float], *, rigid: bool) -> Supports:
    """Return the supports of a disc, whose bearing has the stiffness of its force (N) under each
    torque: bearing and output (torque, 1).
    """
    bearing = output = np.full((len(forces), 1), math.inf)
    eccentric = drive.eccentric
    if not rigid:
        bearing = np.array([[eccentric.cranks * eccentric.stiffness(each)] for each in forces])
        if math.isfinite(eccentric.circle):
            output = bearing * eccentric.circle**2
    return Supports(bearing, output, drive.output.circle if drive.output else math.inf)


def nominal_gaps(drive: Drive, crank: Floats) -> Floats:
    """Return the gaps (crank, 1, N), m, of the nominal stage at crank angles (crank,), rad."""
    return gaps(drive.stage, pin_angles(drive.stage, crank), drive.relief)[:, None]


def crank_angles_of_pitch(drive: Drive) -> Floats:
    """Return crank angles (crank,), rad, evenly spaced over one pitch of the pins."""
    return 2 * math.pi / drive.stage.pins * np.arange(_RIPPLE) / _RIPPLE
