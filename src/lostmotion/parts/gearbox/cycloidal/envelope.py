"""Second branch of envelope lobes in a drawing: by which method it stiffens the contacts, and by
how much.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Literal

from lostmotion.laws.cycloid.envelope import in_range_of_rule, stiffening_by_rule
from lostmotion.laws.cycloid.envelope_contact import stiffening_by_solution
from lostmotion.parts.gearbox.gearbox import refuse

if TYPE_CHECKING:
    from lostmotion.laws.cycloid.stage import Stage

BranchMethod = Literal["rule", "exact"]


@dataclass(frozen=True, slots=True)
class Branches:
    """By how many times the second branch stiffens the contacts, and the method used: "rule", or
    "exact" for the contact along the whole flank.
    """

    stiffening: float
    method: BranchMethod


def check_branches(stage: Stage, asked: BranchMethod | None) -> None:
    """Raise the validation error of a method for a stage without a second branch, or of the rule
    outside of its range.
    """
    if asked is not None and stage.kind != "lobe envelope":
        raise refuse(
            f'envelope = "{asked}" with form = "{stage.kind}"',
            "lobes that are an envelope",
            'form = "lobe envelope"',
        )
    if asked == "rule" and not in_range_of_rule(stage):
        why = f'envelope = "rule" with K1 = e N/R of {stage.shortening:.3g} and {stage.pins} lobes'
        raise refuse(
            why, "K1 from 0.40 to 0.81 and 14 to 40 lobes for the rule", 'envelope = "exact"'
        )


def branches(stage: Stage, asked: BranchMethod | None) -> Branches | None:
    """Return the effect of the second branch by the method asked for, by default the rule in its
    range; None for stages without one.
    """
    if stage.kind != "lobe envelope":
        return None
    if asked == "exact" or not in_range_of_rule(stage):
        return Branches(stiffening_by_solution(stage), "exact")
    return Branches(stiffening_by_rule(stage), "rule")
