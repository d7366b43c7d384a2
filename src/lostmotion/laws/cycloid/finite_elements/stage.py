"""Contact of planet and ring by finite elements: load sharing, pressures, rotation and stresses of
a stage under torque.

Each wheel is a plane elastic body with curved elements. Every contact is divided into intervals,
and each interval is the side of one element on both wheels. The unknowns of a contact are the
pressures at the ends of its intervals, linear between them. Gaps and lines of action are those of
the true profile, not of the mesh. Linear solves under these pressures yield the compliance C of
both wheels; the pressures p and the rotation theta then satisfy, for every torque T on a width b,

    w = g + C p - l theta >= 0,  p >= 0,  w p = 0,  l p = T/b

where g and l are gap and arm weighted with the hat functions of the pressures. The closed nodes are
found by the primal-dual active set method, bordered by the row of the torque. The slip of the
flanks on the pins and the square of the rotation enter the gaps to second order. Valid for small
strain, without friction. The planet's fixed circle turns by theta about its own centre, which stays
in place. In a planet with holes for output pins theta is the mean rotation of these, weighted with
the pressure of the pins, and the bore slides on its rigid bearing.

Source: M. Hintermüller, K. Ito, K. Kunisch, SIAM J. Optim. 13 (2002) 865 (active set as a
semismooth Newton method); K. Johnson, Contact Mechanics, 1985, section 4.2 (half-width).
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import TYPE_CHECKING, Final

import numpy as np

from lostmotion.errors import DidNotConvergeError
from lostmotion.laws.contact import equivalent_modulus
from lostmotion.laws.cycloid.bodies import ring_reach
from lostmotion.laws.cycloid.finite_elements.elasticity import Elasticity
from lostmotion.laws.cycloid.finite_elements.equilibrium import Solved, System
from lostmotion.laws.cycloid.finite_elements.mesh import (
    MM,
    Blank,
    LoadedHole,
    Meshes,
    check_installed,
)
from lostmotion.laws.cycloid.finite_elements.selection import OnEnvelope, OnPins
from lostmotion.laws.cycloid.finite_elements.wheel import ElasticWheel
from lostmotion.laws.cycloid.geometry import gaps as relief_gaps
from lostmotion.laws.cycloid.geometry import pin_angles
from lostmotion.laws.cycloid.stage import Modification
from lostmotion.laws.perforated_disc import pin_forces

if TYPE_CHECKING:
    from collections.abc import Callable

    from lostmotion.laws.cycloid.bodies import ElasticBody
    from lostmotion.laws.cycloid.finite_elements.contours import Contacts, Points
    from lostmotion.laws.cycloid.finite_elements.envelope import EnvelopeContacts
    from lostmotion.laws.cycloid.finite_elements.wheel import Field
    from lostmotion.laws.cycloid.stage import Stage
    from lostmotion.laws.perforated_disc_series import Holes
    from lostmotion.spatial import Floats

# How often contacts grow where pressure reaches their edges, or gaps close beyond them.
_MOST_GROWTHS: Final = 8
# Angles at which the relief of an envelope stage is checked.
_ROUND: Final = 721
# Thinnest web around a hole, over its radius.
_THINNEST: Final = 0.02
# Largest element of the coarser mesh, over the pitch.
_COARSE: Final = 0.2
# Unknowns of a wheel that fit into a few GB.
_MOST_UNKNOWNS: Final = 2_000_000
# Order of convergence of the rotation at the inner corners between pins (measured: 1.5).
_CONVERGENCE: Final = 1.5


@dataclass(frozen=True, slots=True)
class Loaded:
    """A stage under torques (torque,), N m; SI units.

    theta      (contact,) from the line of centres, rad: of every pin or lobe; with an envelope ring
               of a pin with the same arm as each contact
    place      (contact,) point of contact, complex, m
    rotation   (torque,) of the planet against the ring, rad, from the unloaded position without
               gaps, extrapolated from two meshes
    error      (torque,) difference of the rotation between the two meshes, rad
    stiffness  (torque,) derivative of the torque by the rotation, N m/rad
    forces     (torque, contact) N
    peak       (torque, contact) largest pressure, Pa: of the half-ellipse with the force and second
               moment found; with an envelope ring the largest mean over neighbouring nodes
    half_width (torque, contact) half of the ellipse's axis; with an envelope ring of the loaded
    length, m
    wheels     planet and, unless it is rigid, ring, on the finer mesh
    pressures  (torque, node) Pa
    """

    torque: Floats
    theta: Floats
    place: Points
    rotation: Floats
    error: Floats
    stiffness: Floats
    forces: Floats
    peak: Floats
    half_width: Floats
    wheels: tuple[ElasticWheel, ...]
    pressures: Floats

    def largest(self, k: int) -> tuple[float, float]:
        """Return the largest von Mises stress (Pa) and equivalent strain in both wheels under
        torque k.
        """
        found = [wheel.largest(self.pressures[k]) for wheel in self.wheels]
        return max(each[0] for each in found), max(each[1] for each in found)

    def fields(self, k: int) -> list[Field]:
        """Return the fields of the wheels under torque k; the planet's displacement excludes the
        rotation of its fixed circle.
        """
        return [wheel.field(self.pressures[k]) for wheel in self.wheels]


def _silent(_what: str, _done: int, _of: int) -> None:
    """Show no progress."""


def loaded_stage(  # noqa: PLR0913 - geometry, bodies, load, mesh
    stage: Stage,
    planet: ElasticBody,
    ring: ElasticBody | None,
    width: float,
    torques: Floats,
    *,
    crank: float = 0.0,
    gaps: Floats | None = None,
    relief: Modification | None = None,
    order: int = 2,
    intervals: int = 5,
    terms: int = 0,
    meshes: Meshes | None = None,
    progress: Callable[[str, int, int], None] = _silent,
) -> Loaded:
    """Return a stage under torques (torque,), N m above zero, by finite elements.

    planet, ring  the wheels, with their stress states; the largest stresses are those of plane
                  strain only. Without a ring its pins are rigid. Holes of the planet take its
                  torque as in `perforated_disc`, the first of them at angle zero of the planet
    width         of the contact, m
    crank         crank angle, rad
    gaps          (N,) at each pin or lobe, m, zero or more; default: none, and with an envelope
                  ring always
    relief        modification of the toothed wheel, whose gaps are added
    order         of the elements
    intervals     elements over the 2.6 half-widths that are meshed of each contact, on the coarser
                  mesh; the finer one halves every element
    terms         of the displacements over the width, in three dimensions with free faces
                  (`elasticity`), with pressures uniform over the width and gaps that are means over
                  it; zero: plane, with the stress states of the wheels
    meshes        those of the same wheels under another elastic law, with the contacts that grew
                  under the same load there, and where new ones are kept
    progress      called with what is done, how much of it and of how much

    Raises ValueError, before meshing, for wheels that are too thin and for interfering flanks,
    LostmotionError without NGSolve, DidNotConvergeError where contacts would outgrow their lobes
    and for more than 2 million unknowns.
    """
    relief = relief or Modification()
    gap = _gaps(stage, crank, gaps, relief)
    _check(stage, planet, ring, torques)
    check_installed()
    modulus = equivalent_modulus(
        planet.young,
        planet.nu,
        math.inf if ring is None else ring.young,
        0.0 if ring is None else ring.nu,
    )
    load = 4 * float(np.max(torques)) / (stage.planet_pitch_radius * stage.pins * width * modulus)
    envelope = stage.kind == "lobe envelope"
    kept = Meshes() if meshes is None else meshes
    flanks = kept.flanks.setdefault(
        (stage, crank, load, intervals, relief),
        OnEnvelope(stage, crank, load, intervals, relief)
        if envelope
        else OnPins(stage, crank, load, intervals),
    )
    for _ in range(_MOST_GROWTHS):
        made, at = flanks.chosen()
        two = _TwoMeshes(
            made,
            at,
            (planet, ring),
            (width, torques, np.zeros(len(made.theta)) if envelope else gap),
            (order, terms, intervals),
            kept,
            progress,
        )
        system, fine = two.solved(1)
        pressures = np.array([each.pressures for each in fine])
        reach, at_last = system.outgrown(fine)
        if not (reach.any() or at_last):
            break
        flanks.grow(at, reach, at_last=at_last)
    else:
        raise DidNotConvergeError(
            "the contacts outgrow their lobes: take a smaller torque or a stiffer material"
        )
    _, coarse = two.solved(0)
    turn, before = (np.array([each.turn for each in found]) for found in (fine, coarse))
    forces, peak, half_width = system.by_lobe(pressures)
    return Loaded(
        torque=np.asarray(torques, dtype=float),
        theta=made.theta,
        place=made.place,
        rotation=turn + (turn - before) / (2**_CONVERGENCE - 1),
        error=np.abs(turn - before),
        stiffness=np.array([width / each.slope for each in fine]),
        forces=forces * width * MM,
        peak=peak * MM**2,
        half_width=half_width / MM,
        wheels=system.wheels,
        pressures=pressures * MM**2,
    )


class _TwoMeshes:
    """A stage on a coarser mesh (level 0) and a finer one (level 1)."""

    def __init__(
        self,
        made: Contacts | EnvelopeContacts,
        at: dict[int, Floats],
        bodies: tuple[ElasticBody, ElasticBody | None],
        loads: tuple[float, Floats, Floats],
        detail: tuple[int, int, int],
        meshes: Meshes,
        progress: Callable[[str, int, int], None],
    ) -> None:
        """Mesh the wheels.

        detail  order of the elements, terms over the width, and intervals of a contact
        """
        self._made, self._at, self._loads, self._progress = made, at, loads, progress
        self._order, self._terms, intervals = detail
        coarse = _COARSE * 2 * math.pi * made.stage.ring_radius / made.stage.pins * 5 / intervals
        self._blanks = _blanks(made, at, *bodies)
        self._meshes = []
        for n, blank in enumerate(self._blanks):
            self._show("meshing", n)
            self._meshes.append(meshes.of(blank, coarse))
        _check_size(max(int(mesh.ne) for mesh, _ in self._meshes), self._order, self._terms)

    def solved(self, level: int) -> tuple[System, list[Solved]]:
        """Return the system on one of the meshes, and its solution for every torque."""
        width, torques, gap = self._loads
        at = {k: _halved(places) for k, places in self._at.items()} if level else self._at
        wheels = []
        for n, (blank, meshes) in enumerate(zip(self._blanks, self._meshes, strict=True)):
            # the finer one is solved first
            self._show("solving", (2 - level) * len(self._blanks) + n)
            law = Elasticity(blank.body, width, self._terms)
            wheels.append(ElasticWheel(blank, law, self._made, at, meshes[level], self._order))
        system = System(self._made, at, gap, tuple(wheels))
        return system, [system.solve(float(torque) / width) for torque in torques]

    def _show(self, what: str, done: int) -> None:
        self._progress(f"finite elements: {what}", done, 3 * len(self._blanks) + 1)


def _check_size(elements: int, order: int, terms: int) -> None:
    """Raise DidNotConvergeError for a finer mesh with too many unknowns; `elements` are those of
    the coarser one.
    """
    # a triangle has order squared over two of its own, and the finer mesh four times as many
    unknowns = 2 * elements * order**2 * (3 * terms or 2)
    if unknowns > _MOST_UNKNOWNS:
        found = (
            f"a wheel would have {unknowns / 1e6:.2g} million unknowns, more than "
            f"{_MOST_UNKNOWNS / 1e6:g} million"
        )
        raise DidNotConvergeError(f"{found}: take a lower order, fewer elements or two dimensions")


def _gaps(stage: Stage, crank: float, gaps: Floats | None, relief: Modification) -> Floats:
    """Return the gaps (N,), m, at pins or lobes. Raises ValueError for interfering flanks, and for
    gaps of single lobes of an envelope ring.
    """
    theta = pin_angles(stage, np.array([crank]))[0]
    gap = np.zeros(stage.pins) if gaps is None else np.asarray(gaps, dtype=float)
    if gap.shape != (stage.pins,) or not np.isfinite(gap).all():
        raise ValueError(
            f"gaps are needed for each of the {stage.pins} pins or lobes, not of shape {gap.shape}"
        )
    if stage.kind == "lobe envelope":
        if gap.any():
            raise ValueError(
                "gaps of single lobes are those of the first branch alone: state a relief for "
                "an envelope ring"
            )
        theta = np.linspace(0, 2 * math.pi, _ROUND)
        gap = np.zeros(_ROUND)
    gap = gap + relief_gaps(stage, theta, relief)
    if gap.min() < 0:
        k = int(gap.argmin())
        where = (
            f"at θ = {math.degrees(theta[k]):.0f}°"
            if stage.kind == "lobe envelope"
            else f"at pin {k}"
        )
        raise ValueError(
            f"flanks interfere before they are loaded, {where} by {-gap[k] * 1e6:.3g} µm: take "
            "clearances of zero or more"
        )
    return gap


def _check(stage: Stage, planet: ElasticBody, ring: ElasticBody | None, torques: Floats) -> None:
    """Raise ValueError for wheels that cannot be meshed or loads that are none."""
    root = (
        stage.ring_radius
        - stage.pin_radius
        + (0.0 if stage.has_planet_pins else -stage.eccentricity)
    )
    if not 0 < planet.edge < root:
        raise ValueError(
            f"the hub's radius is {planet.edge * MM:g} mm, but teeth or pins reach in to "
            f"{root * MM:.4g} mm: choose a smaller hub"
        )
    if planet.holes is not None:
        if planet.holes.bearings:
            raise ValueError(
                "its disc is on the bearings of several crankshafts, which are not meshed: "
                "take one central eccentric"
            )
        _check_holes(planet, planet.holes, root)
    if ring is not None and ring.edge <= (reach := ring_reach(stage)):
        found = f"the ring's outer radius is {ring.edge * MM:g} mm"
        raise ValueError(
            f"{found}, but its teeth or pins reach out to {reach * MM:.4g} mm: choose a larger one"
        )
    if not (np.ndim(torques) == 1 and np.isfinite(torques).all() and np.min(torques) > 0):
        raise ValueError("torques must be above zero")


def _check_holes(planet: ElasticBody, holes: Holes, root: float) -> None:
    """Raise ValueError for holes without webs around them."""
    webs = {
        "the bore": holes.circle - holes.radius - planet.edge,
        "the teeth": root - holes.circle - holes.radius,
        "each other": 2 * holes.circle * math.sin(math.pi / holes.count) - 2 * holes.radius,
    }
    for where, web in webs.items():
        if web <= _THINNEST * holes.radius:
            raise ValueError(
                f"holes of radius {holes.radius * MM:g} mm leave {web * MM:.3g} mm to {where}: "
                "take smaller holes"
            )


def _blanks(
    made: Contacts | EnvelopeContacts,
    at: dict[int, Floats],
    planet: ElasticBody,
    ring: ElasticBody | None,
) -> list[Blank]:
    """Return the wheels before meshing."""
    holes = () if planet.holes is None else _loaded_holes(made, planet.holes)
    out = [Blank(made.planet_outline(at), planet, made.planet, holes)]
    return out if ring is None else [*out, Blank(made.ring_outline(at), ring, 0.0)]


def _loaded_holes(made: Contacts | EnvelopeContacts, holes: Holes) -> tuple[LoadedHole, ...]:
    """Return the holes with the forces of their pins that balance a unit torque of the contacts."""
    turned = np.exp(1j * made.turn)
    centres = made.planet + holes.circle * turned * np.exp(
        2j * math.pi * np.arange(holes.count) / holes.count
    )
    # the loaded contacts turn the planet clockwise
    forces = pin_forces(holes, -1.0, made.crank - made.turn) * turned
    return tuple(
        LoadedHole(complex(centre), holes.radius, complex(force))
        for centre, force in zip(centres, forces, strict=True)
    )


def _halved(places: Floats) -> Floats:
    """Return the ends of intervals (m) of half the length."""
    return np.sort(np.concatenate([places, (places[1:] + places[:-1]) / 2]))
