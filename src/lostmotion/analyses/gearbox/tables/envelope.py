"""Tables of both branches of an envelope ring: number of contacts, stiffening and its method, lever
arms and gaps of the second contacts.
"""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, Final

from lostmotion.laws.cycloid.envelope_contact import johnson_depth
from lostmotion.reporting.sheet import Cell, Row, Section

if TYPE_CHECKING:
    from collections.abc import Iterator

    from lostmotion.parts.gearbox.cycloidal.examined import BothBranches, Drawn
    from lostmotion.parts.gearbox.cycloidal.stage import CycloidalStage

_DRAWING: Final = "the drawing"
_AS_DRAWN: Final = "the stage as drawn, without tolerances"
# How much larger the peak pressure of the first branch alone is than that of both.
OVERSTATED: Final = "12 to 28 %"
# Errors of the contacts of both branches on elastic bodies, measured by finite elements.
_COUPLED: Final = (
    "contacts of both branches are solved together on the elastic disc and ring: the wind-up "
    "within 1 % of finite elements, "
    "the peak pressure within 5 %"
)
_SETTLED: Final = (
    "1 + c S2/S1 of the lever arms, c = 1.57 - 1.3 K1, within 4 % of the contact along the whole "
    "flank to a depth of 3 mm"
)


def branches_sections(
    gearbox: CycloidalStage, first_stage: CycloidalStage | None, drawn: Drawn
) -> Iterator[Section]:
    """Yield the tables of every stage with envelope lobes."""
    if drawn.before is not None and first_stage is not None:
        yield _contacts(
            "branches-first", "Both branches of the ring, first stage", first_stage, drawn.before
        )
    if drawn.branches is not None:
        yield _contacts("branches", "Both branches of the ring", gearbox, drawn.branches)
        yield _second(drawn.branches)


def _contacts(key: str, title: str, part: CycloidalStage, found: BothBranches) -> Section:
    with_rigid = "over that of the first branch alone" + (
        ", with a rigid disc and ring" if found.elastic else ""
    )
    rows = [
        Row(
            "contacts of both branches, mean",
            (Cell(found.mean, "1", samples=_DRAWING),),
            f"over a turn; {part.pins} of them at the arcs",
        ),
        Row("fewest", (Cell(found.fewest, "1", samples=_DRAWING),)),
        Row("most", (Cell(found.most, "1", samples=_DRAWING),)),
        Row(
            "stiffening of the contacts",
            (Cell(found.effect.stiffening, "1", samples=_AS_DRAWN),),
            with_rigid,
        ),
    ]
    if found.solved is None:
        method = f"stiffening by the rule {_SETTLED}"
        if not found.elastic:
            method += f"; pressures are those of the first branch alone, {OVERSTATED} too large"
    else:
        method = (
            "stiffening by the contact along the whole flank, to a depth of "
            f"{johnson_depth(part.stage) * 1e3:.3g} mm"
        )
        rows += [
            Row(
                "peak pressure along the flanks",
                (Cell(float(found.solved.peak.max()), "GPa", samples=_AS_DRAWN),),
                "over a pitch",
            ),
            Row(
                "largest force of one contact area",
                (Cell(float(found.solved.largest.max()), "N", samples=_AS_DRAWN),),
                "over a pitch",
            ),
        ]
    return Section(
        key, title, ("value",), tuple(rows), f"{_COUPLED}; {method}" if found.elastic else method
    )


def _second(found: BothBranches) -> Section:
    rows = [
        Row(
            f"θ = {math.degrees(theta):.1f}°",
            (
                Cell(float(arm), "mm", samples=_DRAWING),
                Cell(float(gap), "µm", samples=_DRAWING),
            ),
        )
        for theta, arm, gap in zip(found.theta, found.arm, found.gap, strict=True)
    ]
    note = (
        "crank at zero; θ is that of the first contact at the same point of the flank; gap by the "
        "relief, on the side that drives"
    )
    return Section(
        "second-branch", "Contacts of the second branch", ("lever arm", "gap"), tuple(rows), note
    )
