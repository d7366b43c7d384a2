"""Contacts of both branches of an envelope ring of a drawing: their number, their effect, and the
pressure along the whole flank.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import TYPE_CHECKING, Final

import numpy as np

from lostmotion.laws.cycloid.drive import crank_angles_of_pitch
from lostmotion.laws.cycloid.envelope import mean_contacts, second_contacts
from lostmotion.laws.cycloid.envelope_contact import envelope_contact
from lostmotion.laws.cycloid.geometry import arms, gaps
from lostmotion.parts.gearbox.cycloidal.envelope import branches

if TYPE_CHECKING:
    from lostmotion.laws.cycloid.envelope_contact import EnvelopeContact
    from lostmotion.parts.gearbox.cycloidal.envelope import Branches
    from lostmotion.parts.gearbox.cycloidal.stage import CycloidalStage
    from lostmotion.spatial import Floats

_TURN: Final = 360


@dataclass(frozen=True)
class BothBranches:
    """Contacts of both branches of a stage.

    mean, fewest, most  number of contacts of both branches over a turn of the crank
    effect              stiffening of the contacts with a rigid disc and ring, and its method
    elastic             whether disc or ring is elastic, so that the contacts of both branches are
                        solved together on them
    theta, arm, gap     (contact,) rad, m and m of the second contacts at crank zero that turn the
                        disc as its first ones do
    solved              equilibrium along the whole flank, each (crank,) over a pitch; None with the
                        rule
    """

    mean: float
    fewest: int
    most: int
    effect: Branches
    elastic: bool
    theta: Floats
    arm: Floats
    gap: Floats
    solved: EnvelopeContact | None


def both_branches(part: CycloidalStage, torque: float) -> BothBranches | None:
    """Return the contacts of both branches of a stage under a torque (N m) on one disc; None
    without a second branch.

    Raises DidNotConvergeError where the contacts cannot carry the torque.
    """
    stage, drive = part.stage, part.drive
    effect = branches(stage, part.envelope)
    if effect is None:
        return None
    first = int(mean_contacts(stage)[0])
    found = np.isfinite(
        second_contacts(stage, 2 * math.pi / stage.pins * np.arange(_TURN) / _TURN)
    ).sum(axis=1)
    theta = -stage.lobes * second_contacts(stage, [0.0])[0]
    theta -= 2 * math.pi * np.round(theta / (2 * math.pi))
    driving = np.sort(theta[np.isfinite(theta) & (arms(stage, theta) > 0)])
    solved = None
    if effect.method == "exact":
        solved = envelope_contact(
            stage, drive.flanks, torque, crank_angles_of_pitch(drive), drive.relief
        )
    return BothBranches(
        mean=sum(mean_contacts(stage)),
        fewest=first + int(found.min()),
        most=first + int(found.max()),
        effect=effect,
        elastic=not (drive.disc_body is None and drive.ring_body is None),
        theta=driving,
        arm=arms(stage, driving),
        gap=gaps(stage, driving, drive.relief),
        solved=solved,
    )
