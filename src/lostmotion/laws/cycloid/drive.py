"""A cycloidal stage with its supports as springs in series: the wind-up of the output through each member.

Members are those of the stage itself, at its output: the contacts of the lobes, the bending of pins or lobes, the bodies of disc and ring, bearing
and shaft of the eccentric, the output pins. Members before and behind the stage (a first stage, shafts, the frame) are added outside.

The eccentric's bearing stiffens with its load and is represented by its secant stiffness. In a drive whose crankshafts carry the output (RV) the same
bearings support the disc against translation, as a single eccentric does, and against rotation, as output pins would. Static, first order in the
gaps. The discs share the torque equally here; `cycloid.tolerances` treats the effect of their differences.

Source: K = 1/sum(1/K_i) with K_ecc = k (e z)^2 and K_pins = k_w Rw^2 n_w/4 after M. Lehmann, TU München 1976; the crankshafts by statics.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, field, replace
from typing import TYPE_CHECKING, Final

import numpy as np

from lostmotion.laws.cycloid.contact import Flanks, LoadSharing, Supports, load_sharing, output_pin_stiffness
from lostmotion.laws.cycloid.geometry import Modification, Stage, first_contact_error, gaps, pin_angles
from lostmotion.laws.rolling.radial import ROLLER_EXPONENT, element_angles, radial_shift

if TYPE_CHECKING:
    from lostmotion.spatial import Floats

# Crank angles within one pitch over which the ripple is averaged.
_RIPPLE: Final = 6
# Of the largest arm. A flank nearer to the line of centres that interferes by a micrometre would stop a rigid disc on a rigid eccentric; a real one
# is pushed aside.
LEAST_ARM: Final = 0.1
# Share of a torque that is practically none.
_REST: Final = 0.01
# Crank angles over a turn, to average the crankshafts' forces.
_ROUND: Final = 72


@dataclass(frozen=True, slots=True)
class Eccentric:
    """Stiffness of the eccentric, per disc and crankshaft: its bearing, and the shaft with its seats behind it; infinite means rigid.

    A rolling bearing by its `elements` of `element_stiffness` K (N/m^n, `rolling.roller_stiffness`) and `exponent` n, without clearance; or, with no
    elements, by `bearing` N/m. `shaft` N/m. `cranks` shafts on a circle of radius `circle` (m) carry the output (RV); one central eccentric does not:
    infinite. Raises ValueError for impossible values.
    """

    bearing: float = math.inf
    elements: int = 0
    element_stiffness: float = math.inf
    exponent: float = ROLLER_EXPONENT
    shaft: float = math.inf
    cranks: int = 1
    circle: float = math.inf

    def __post_init__(self) -> None:
        """Refuse stiffnesses of zero or less, bearings with too few elements, and a single crankshaft off the centre."""
        if not (self.bearing > 0 and self.element_stiffness > 0 and self.shaft > 0 and self.circle > 0):
            raise ValueError("stiffness and circle of an eccentric must be above zero; infinite means rigid")
        if self.elements and (self.elements < 3 or math.isinf(self.element_stiffness)):  # noqa: PLR2004 - two support one direction only
            raise ValueError("a rolling bearing needs three elements or more, and their stiffness")
        if self.cranks < 1 or (self.cranks == 1) != math.isinf(self.circle):
            raise ValueError("one eccentric must be at the centre, two or more crankshafts on a circle")

    def bearing_stiffness(self, force: float) -> float:
        """Return the secant stiffness (N/m) of one bearing under this force (N)."""
        if not self.elements:
            return self.bearing
        if force <= 0:
            return 0.0
        shift = radial_shift(force, 0.0, self.element_stiffness, self.exponent, element_angles(self.elements))
        return force / float(shift)

    def stiffness(self, force: float) -> float:
        """Return the stiffness (N/m) of bearing and shaft of one crank in series under this force (N)."""
        bearing = self.bearing_stiffness(force)
        soft = (1 / bearing if bearing else math.inf) + 1 / self.shaft
        return 1 / soft if soft else math.inf


@dataclass(frozen=True, slots=True)
class OutputPins:
    """Output pins that take the torque from the discs: `count` on the radius `circle` (m), each of `stiffness` N/m at the discs."""

    count: int
    circle: float
    stiffness: float = math.inf


@dataclass(frozen=True, slots=True)
class Drive:
    """A stage with its supports. `disc_body` and `ring_body` rad/(N m), per disc and its share of the torque; zero means rigid."""

    stage: Stage
    flanks: Flanks
    relief: Modification = field(default_factory=Modification)
    discs: int = 1
    eccentric: Eccentric = field(default_factory=Eccentric)
    output: OutputPins | None = None
    disc_body: float = 0.0
    ring_body: float = 0.0

    @property
    def bodies(self) -> float:
        """Return the compliance of disc and ring bodies, rad per N m on one disc."""
        return self.disc_body + self.ring_body


def crank_lever(drive: Drive) -> float:
    """Return the force (N) on each crank's bearing per N m on one disc, averaged over a turn: 1/(e z) for one central eccentric.

    On crankshafts the mesh's reaction 1/(e z), equal for all, adds to the torque's 1/Rc, whose direction turns around the circle.
    """
    lever, circle = drive.stage.planet_pitch_radius, drive.eccentric.circle
    if math.isinf(circle):
        return 1 / lever
    around = np.cos(2 * math.pi * np.arange(_ROUND) / _ROUND)
    return float(np.sqrt(lever**-2 + circle**-2 + 2 * around / (lever * circle)).mean()) / drive.eccentric.cranks


def crank_play(drive: Drive) -> float:
    """Return the rotation (rad) of the output per metre of diametral clearance in every crank bearing: 1/(e z) for one central eccentric.

    Both directions together. By virtual work: every bearing moves by half its clearance along its own force. For several crankshafts this is an upper
    bound, reached under load.
    """
    return crank_lever(drive) * drive.eccentric.cranks


def crank_force(drive: Drive, torque: float) -> float:
    """Return the force (N) on each crank's bearing under a torque (N m) on one disc of the nominal stage, averaged over a pitch.

    Larger than `crank_lever` times the torque, because lobes also push a little along the line of centres.
    """
    force = abs(torque) * crank_lever(drive)
    crank = crank_angles_of_pitch(drive)
    answer = load_sharing(drive.stage, drive.flanks, [torque], crank, nominal_gaps(drive, crank), _supports(drive, force, rigid=False)).checked()
    return float(answer.bearing_force.mean()) * crank_lever(drive) * drive.stage.planet_pitch_radius


def loaded_disc(drive: Drive, torque: float, crank: Floats, gap: Floats, *, rigid_eccentric: bool = False, threads: int = 1) -> LoadSharing:
    """Return the load sharing of one disc under its torque (N m, not zero) at crank angles (crank,) with gaps (crank, draw, N), with the bodies.

    The eccentric's bearing has its secant stiffness under the force that it carries in the nominal stage. Raises DidNotConvergeError.
    """
    force = crank_force(drive, torque) if drive.eccentric.elements and not rigid_eccentric else abs(torque) * crank_lever(drive)
    supports = _supports(drive, force, rigid=rigid_eccentric)
    return load_sharing(drive.stage, drive.flanks, [torque], crank, gap, supports, threads=threads).checked()


def rest_angle(drive: Drive, crank: Floats, gap: Floats, torque: float, *, rigid_eccentric: bool = False) -> Floats:
    """Return the angle (crank, draw), rad, at which interfering flanks hold a disc without torque; NaN where they leave it play.

    `gap` (crank, draw, N) m; `torque` N m, positive: the mean of the angles under +- a hundredth of it. Raises DidNotConvergeError where interference
    is beyond the contact law, or its forces are 10 000 times those of `torque`.
    """
    stuck = interferes(drive, crank, gap)
    chosen = np.flatnonzero(stuck.any(axis=0))
    out = np.full(stuck.shape, math.nan)
    if len(chosen):
        small = _REST * torque
        either = [loaded_disc(drive, each, crank, gap[:, chosen], rigid_eccentric=rigid_eccentric).rotation[0] for each in (-small, small)]
        out[:, chosen] = np.where(stuck[:, chosen], (either[0] + either[1]) / 2, math.nan)
    return out


def interferes(drive: Drive, crank: Floats, gap: Floats) -> np.ndarray[tuple[int, ...], np.dtype[np.bool_]]:
    """Return for which gaps (crank, draw, N) a disc's own flanks leave it no play: (crank, draw)."""
    theta = pin_angles(drive.stage, crank)[:, None]
    return first_contact_error(drive.stage, theta, gap, LEAST_ARM) + first_contact_error(drive.stage, -theta, gap, LEAST_ARM) < 0


def _supports(drive: Drive, force: float, *, rigid: bool) -> Supports:
    held, around = math.inf, 1 / drive.bodies if drive.bodies else math.inf
    eccentric = drive.eccentric
    if not rigid:
        each = eccentric.stiffness(force)
        held = eccentric.cranks * each
        if math.isfinite(eccentric.circle):
            soft = drive.bodies + 1 / (held * eccentric.circle**2)
            around = 1 / soft if soft else math.inf
    return Supports(held, around, drive.output.circle if drive.output else math.inf)


def nominal_gaps(drive: Drive, crank: Floats) -> Floats:
    """Return the gaps (crank, 1, N) in m of the nominal stage."""
    return gaps(drive.stage, pin_angles(drive.stage, crank), drive.relief)[:, None]


def crank_angles_of_pitch(drive: Drive) -> Floats:
    """Return crank angles (rad) that cover one pitch of pins uniformly."""
    return 2 * math.pi / drive.stage.pins * np.arange(_RIPPLE) / _RIPPLE


def wind_up_by_member(drive: Drive, torque: Floats) -> dict[str, Floats]:
    """Return the wind-up (rad) through each member under torques (torque,), positive, N m on the whole nominal drive.

    Measured from the first contact, so without the play, and for interfering flanks from their rest angle; the members add up to the whole wind-up. A
    rigid member has zeros. Raises DidNotConvergeError where a load is beyond the contact law.
    """
    torque = np.asarray(torque, dtype=float)
    crank = crank_angles_of_pitch(drive)
    gap = nominal_gaps(drive, crank)
    bare = replace(drive, flanks=replace(drive.flanks, bending=0.0), disc_body=0.0, ring_body=0.0)
    bent = replace(bare, flanks=drive.flanks)
    first = first_contact_error(drive.stage, pin_angles(drive.stage, crank), gap[:, 0])
    stuck = interferes(drive, crank, gap)[:, 0]

    def start(held: Drive, each: float, *, rigid: bool) -> float:
        return float(np.where(stuck, rest_angle(held, crank, gap, each, rigid_eccentric=rigid)[:, 0], first).mean())

    lobes = "planet pins" if drive.stage.twin else "ring pins" if drive.stage.kind == "ring pins" else "ring lobes"
    out = {name: np.zeros_like(torque) for name in ("lobe contacts", lobes, "disc body", "ring body", "eccentric bearing", "eccentric shaft")}
    for k, each in enumerate(torque / drive.discs):
        contact = float(loaded_disc(bare, each, crank, gap, rigid_eccentric=True).rotation.mean()) - start(bare, each, rigid=True)
        bending = contact
        if drive.flanks.bending:
            bending = float(loaded_disc(bent, each, crank, gap, rigid_eccentric=True).rotation.mean()) - start(bent, each, rigid=True)
        eccentric = float(loaded_disc(bent, each, crank, gap).rotation.mean()) - start(bent, each, rigid=False) - bending
        out["lobe contacts"][k] = contact
        out[lobes][k] = bending - contact
        soft = 1 / drive.eccentric.bearing_stiffness(crank_force(bent, each))
        share = soft / (soft + 1 / drive.eccentric.shaft) if soft else 0.0
        out["eccentric bearing"][k] = eccentric * share
        out["eccentric shaft"][k] = eccentric * (1 - share)
    out["disc body"] = drive.disc_body * torque / drive.discs
    out["ring body"] = drive.ring_body * torque / drive.discs
    if drive.output is not None:
        stiffness = output_pin_stiffness(drive.output.stiffness, drive.output.circle, drive.output.count)
        # One disc loads half of the pins. A second one, half a turn away, loads the other half and keeps the first one's pins from bending
        # sideways; three or more support every pin in both directions.
        out["output pins"] = torque / (stiffness * {1: 1, 2: 2}.get(drive.discs, 4))
    return out
