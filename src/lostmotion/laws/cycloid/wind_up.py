"""Wind-up of the output of a cycloidal stage by member, its supports as springs in series.

The members are those of the stage itself: contacts of the lobes, bending of pins or lobes, bodies
of disc and ring, bearing and shaft of the eccentric, output pins. Members before and after the
stage (a first stage, shafts, the frame) are not included. Validity as in `cycloid.drive`.

Source: K = 1/sum(1/K_i) with K_ecc = k (e z)^2 and K_pins = k_w Rw^2 n_w/4 after M. Lehmann, TU
München 1976; the crankshafts by statics.
"""

from __future__ import annotations

from dataclasses import replace
from typing import TYPE_CHECKING

import numpy as np

from lostmotion.laws.cycloid.contact import (
    output_pin_stiffness,
)
from lostmotion.laws.cycloid.drive import (
    Drive,
    crank_angles_of_pitch,
    crank_forces,
    interferes,
    nominal_gaps,
    rest_angle,
    rotations,
)
from lostmotion.laws.cycloid.geometry import (
    first_contact_angle,
    pin_angles,
)

if TYPE_CHECKING:
    from lostmotion.spatial import Floats


def wind_up_by_member(drive: Drive, torque: Floats) -> dict[str, Floats]:
    """Return the wind-up (torque,), rad, due to each member under positive torques (torque,), N m,
    on the whole nominal drive.

    Wind-up is measured from the first contact, so play is not included; for interfering flanks it
    is measured from their rest angle. The members add up to the total wind-up. A rigid member has
    zeros. Raises DidNotConvergeError where a load is beyond the contact law.
    """
    torque = np.asarray(torque, dtype=float)
    each_disc = torque / drive.discs
    crank = crank_angles_of_pitch(drive)
    gap = nominal_gaps(drive, crank)
    with_bending = replace(drive, disc_body=None, ring_body=None)
    with_disc = replace(drive, ring_body=None)
    contacts_only = replace(with_bending, flanks=replace(drive.flanks, bending=0.0))
    first = first_contact_angle(drive.stage, pin_angles(drive.stage, crank), gap[:, 0])
    interfering = interferes(drive, crank, gap)[:, 0]

    def wound(loaded: Drive, *, rigid: bool) -> Floats:
        turned, _ = rotations(loaded, each_disc, crank, gap, rigid_eccentric=rigid)
        start = np.tile(first, (len(each_disc), 1))
        for k, each in enumerate(each_disc.tolist() if interfering.any() else ()):
            rest = rest_angle(loaded, crank, gap, each, rigid_eccentric=rigid)[:, 0]
            start[k, interfering] = rest[interfering]
        return np.array([one.mean() - two.mean() for one, two in zip(turned, start, strict=True)])

    lobes = (
        "planet pins"
        if drive.stage.has_planet_pins
        else "ring pins"
        if drive.stage.kind == "ring pins"
        else "ring lobes"
    )
    out = {
        name: np.zeros_like(torque)
        for name in (
            "lobe contacts",
            lobes,
            "disc body",
            "ring body",
            "eccentric bearing",
            "eccentric shaft",
        )
    }
    contact = wound(contacts_only, rigid=True)
    bending = wound(with_bending, rigid=True) if drive.flanks.bending else contact
    supported = wound(with_bending, rigid=False)
    on_disc = wound(with_disc, rigid=False) if drive.disc_body else supported
    out["lobe contacts"][:] = contact
    out[lobes][:] = bending - contact
    out["disc body"][:] = on_disc - supported
    if drive.ring_body:
        out["ring body"][:] = wound(drive, rigid=False) - on_disc
    forces = (
        crank_forces(with_bending, tuple(each_disc.tolist()))
        if drive.eccentric.elements
        else np.zeros_like(torque)
    )
    for k, force in enumerate(forces):
        soft = 1 / drive.eccentric.bearing_stiffness(force)
        share = soft / (soft + 1 / drive.eccentric.shaft) if soft else 0.0
        out["eccentric bearing"][k] = (supported[k] - bending[k]) * share
        out["eccentric shaft"][k] = (supported[k] - bending[k]) * (1 - share)
    if drive.output is not None:
        out["output pins"] = output_pin_wind_up(drive, torque, 1 / drive.output.stiffness)
    return out


def output_pin_wind_up(drive: Drive, torque: Floats, compliance: Floats | float) -> Floats:
    """Return the wind-up (torque,), rad, under torques (torque,), N m, on the whole drive if each
    output pin deflects at the discs by `compliance`.

    compliance  m/N, one or (torque,)

    One disc loads half of the pins. A second one, half a turn away, loads the other half and
    supports the pins of the first one sideways. Three or more discs support every pin in both
    directions. Zeros without output pins.
    """
    if drive.output is None:
        return np.zeros_like(torque)
    each = output_pin_stiffness(1.0, drive.output.circle, drive.output.count) * {1: 1, 2: 2}.get(
        drive.discs, 4
    )
    return np.asarray(torque * compliance / each)
