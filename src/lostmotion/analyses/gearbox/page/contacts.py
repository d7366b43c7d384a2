"""Contacts of a cycloidal gearbox by its drawing: geometry, load of the lobes, both branches of an
envelope ring, friction.
"""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, Any, Final

import numpy as np

from lostmotion.laws.cycloid.envelope_contact import johnson_depth
from lostmotion.laws.cycloid.geometry import (
    flank,
    play,
    pressure_angles,
    smallest_convex_radius,
    valley_radius,
)
from lostmotion.laws.cycloid.geometry import ratio as ratio_of
from lostmotion.parts.gearbox.cycloidal.examined import FRICTION_LOADS
from lostmotion.printed import digits, stated_text
from lostmotion.reporting.sheet import Cell, Row, length, table

if TYPE_CHECKING:
    from collections.abc import Iterator

    from lostmotion.parts.gearbox.cycloidal import CycloidalGearbox
    from lostmotion.parts.gearbox.cycloidal.examined import BothBranches, ExaminedDrawing, Lobes
    from lostmotion.parts.gearbox.cycloidal.stage import CycloidalStage
    from lostmotion.reporting.sheet import Section

_DRAWING: Final = "the drawing"
_AS_DRAWN: Final = "the stage as drawn, without tolerances"
_NEVER_TOUCHING: Final = 1e-12
# Above this share friction invalidates the loads, which are computed without it.
_LARGE: Final = 0.2
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


def geometry_section(gearbox: CycloidalGearbox) -> Section:
    """Return the geometry of the output stage, beside that of a cycloidal first stage."""
    first = gearbox.cycloidal_first_stage
    found = [] if first is None else [_stage_rows(first, ratio_of(first.stage, "ring"))]
    found.append(_stage_rows(gearbox, ratio_of(gearbox.stage, gearbox.fixed)))
    rows = [
        (label, *(each[k][1] for each in found), note)
        for k, (label, _, note) in enumerate(found[0])
    ]
    columns = ["value"] if first is None else ["first stage", "stage at the output"]
    whole = f"the whole gearbox: {gearbox.ratio:g} turns of the input per turn of the output" + (
        ", the other way" if gearbox.ratio < 0 else ""
    )
    return table("geometry", "Geometry", columns, rows, whole, samples=_DRAWING)


def _stage_rows(part: CycloidalStage, steps: int) -> list[tuple[str, Cell, str]]:
    stage, drive = part.stage, part.drive
    wheel = "ring" if stage.has_planet_pins else "disc"
    ends = np.linalg.norm(
        flank(stage, np.array([0.0, math.pi / stage.lobes]), drive.relief)[0], axis=-1
    )
    working = np.linspace(0, math.pi, 2001)[1:-1]
    longest = pressure_angles(stage, np.array(math.acos(stage.shortening)))
    sharpest = smallest_convex_radius(stage)
    valley = valley_radius(stage) + stage.pin_radius
    between = 2 * (stage.ring_radius * math.sin(math.pi / stage.pins) - stage.pin_radius)

    def of_length(value: float) -> Cell:
        return length(value, stated=True) if math.isfinite(value) else Cell(math.inf, "mm")

    return [
        (
            "ratio of the stage",
            Cell(steps, "1", stated=True),
            "turns of the crank per turn of its output; negative: opposite",
        ),
        ("K1 = e N/R", Cell(stage.shortening, "1", stated=True), "at 1 the profile would loop"),
        (
            "lobes",
            Cell(stage.lobes, "1", stated=True),
            f"of the {wheel}, on {stage.pins} pins or lobes of the other wheel",
        ),
        (f"tip radius of the {wheel}", of_length(float(ends[1])), "with what is ground off"),
        (f"root radius of the {wheel}", of_length(float(ends[0])), "with what is ground off"),
        (
            "smallest convex radius of the flank",
            of_length(sharpest),
            "increase of the pin radius at which undercutting begins"
            if math.isfinite(sharpest)
            else "the flank is nowhere convex: no pin size undercuts it",
        ),
        (
            "radius of the flank's valley",
            of_length(valley),
            "a cutter that mills the profile must be smaller, before relief"
            if math.isfinite(valley)
            else "the flank is nowhere concave",
        ),
        ("room between neighbouring pins", of_length(between), ""),
        (
            "smallest pressure angle",
            Cell(float(pressure_angles(stage, working).min()), "°", stated=True),
            "",
        ),
        (
            "pressure angle at the longest arm",
            Cell(float(longest), "°", stated=True),
            "where cos θ = K1",
        ),
        (
            "play by the relief alone",
            Cell(play(stage, drive.relief), "arcmin"),
            "first order, without tolerances and clearances; negative: flanks interfere",
        ),
    ]


def lobes_section(gearbox: CycloidalGearbox, drawn: ExaminedDrawing) -> Section:
    """Return the load of each loaded lobe, and the largest over a pitch of the crank."""
    cases, several = drawn.lobes, len(drawn.lobes) > 1
    columns = [
        name
        for case in cases
        for name in (f"load at share {case.share:.3g}" if several else "load", "peak pressure")
    ]

    def cells(*pairs: tuple[float, float]) -> tuple[Cell, ...]:
        return tuple(
            Cell(value, unit, samples=_AS_DRAWN)
            for pair in pairs
            for value, unit in zip(map(float, pair), ("N", "GPa"), strict=True)
        )

    loaded = np.flatnonzero(np.max([case.force for case in cases], axis=0) > _NEVER_TOUCHING)
    rows = [
        Row(
            "most heavily loaded lobe, over a pitch of the crank",
            cells(*((case.largest_force, case.largest_peak) for case in cases)),
            key="hardest_over_a_pitch_of_the_crank",
        ),
        *(
            Row(
                f"θ = {math.degrees(cases[0].theta[k]):.1f}°",
                cells(*((case.force[k], case.peak[k]) for case in cases)),
                f"pressure angle {math.degrees(cases[0].pressure_angle[k]):.1f}°",
            )
            for k in sorted(loaded, key=lambda k: cases[0].theta[k])
        ),
    ]
    of_discs = f"one of {gearbox.discs} discs, " if gearbox.discs > 1 else ""
    notes = [
        f"{of_discs}crank at zero, θ from the line of centres",
        *(
            f"share {case.share:.3g}: {_carrying(case)} of {gearbox.pins} lobes carry load, "
            f"{digits(case.bearing)} N on each eccentric bearing"
            for case in cases
        ),
    ]
    if several:
        notes.append("equal discs take a share of 0.5, 0.55 the customary allowance")
    if drawn.branches is not None:
        notes.append(
            "a load includes the lobe's share of the second branch, a pressure is that of the "
            "first branch"
            if drawn.branches.elastic
            else "loads and pressures are those of the first branch alone"
        )
    return table("lobes", "Load of the lobes", columns, rows, "; ".join(notes))


def _carrying(case: Lobes) -> str:
    """Return how many lobes carry load over a pitch of the crank."""
    fewest, most = case.carrying
    return f"{fewest}" if fewest == most else f"{fewest} to {most}"


def branches_sections(gearbox: CycloidalGearbox, drawn: ExaminedDrawing) -> Iterator[Section]:
    """Yield the tables of every stage with envelope lobes."""
    title, first = "Both branches of the ring", gearbox.cycloidal_first_stage
    if drawn.before is not None and first is not None:
        yield _contacts("branches-first", f"{title}, first stage", first, drawn.before)
    if drawn.branches is not None:
        yield _contacts("branches", title, gearbox, drawn.branches)
        yield _second(drawn.branches)


def _contacts(key: str, title: str, part: CycloidalStage, both: BothBranches) -> Section:
    rows = [
        (
            "contacts of both branches, mean",
            Cell(both.mean, "1"),
            f"over a turn; {part.pins} of them at the arcs",
        ),
        ("fewest", Cell(both.fewest, "1"), ""),
        ("most", Cell(both.most, "1"), ""),
        (
            "stiffening of the contacts",
            Cell(both.effect.stiffening, "1", samples=_AS_DRAWN),
            "over that of the first branch alone"
            + (", with a rigid disc and ring" if both.elastic else ""),
        ),
    ]
    if both.solved is None:
        method = f"stiffening by the rule {_SETTLED}"
        if not both.elastic:
            method += f"; pressures are those of the first branch alone, {OVERSTATED} too large"
    else:
        method = (
            "stiffening by the contact along the whole flank, to a depth of "
            f"{johnson_depth(part.stage) * 1e3:.3g} mm"
        )
        peak, largest = float(both.solved.peak.max()), float(both.solved.largest.max())
        rows += [
            (
                "peak pressure along the flanks",
                Cell(peak, "GPa", samples=_AS_DRAWN),
                "over a pitch",
            ),
            (
                "largest force of one contact area",
                Cell(largest, "N", samples=_AS_DRAWN),
                "over a pitch",
            ),
        ]
    note = f"{_COUPLED}; {method}" if both.elastic else method
    return table(key, title, ["value"], rows, note, samples=_DRAWING)


def _second(both: BothBranches) -> Section:
    rows = (
        (f"θ = {math.degrees(theta):.1f}°", arm, gap)
        for theta, arm, gap in zip(both.theta, both.arm, both.gap, strict=True)
    )
    return table(
        "second-branch",
        "Contacts of the second branch",
        {"lever arm": "mm", "gap": "µm"},
        rows,
        "crank at zero; θ is that of the first contact at the same point of the flank; gap by the "
        "relief, on the side that drives",
        samples=_DRAWING,
    )


def friction_sections(drawn: ExaminedDrawing) -> tuple[Section, ...]:
    """Return the tables of efficiency over torque and of backdriving; none without stated
    friction.
    """
    friction = drawn.friction
    if not friction.any:
        return ()
    loads = drawn.read.asked.torque * np.array(FRICTION_LOADS)
    figures = (
        friction.driving(loads) - loads,
        friction.efficiency(loads),
        friction.efficiency_driven_back(loads),
    )
    rows = (
        (f"at {stated_text(load)} N m", _figure(torque, "the input cannot turn it"), *shares)
        for load, torque, *shares in zip(
            *(each.tolist() for each in (loads, *figures)), strict=True
        )
    )
    efficiency = table(
        "friction",
        "Friction",
        {"friction at the output": "N m", "efficiency": "%", "efficiency, driven back": "%"},
        rows,
        "friction at the output: what the input exerts beyond the load, times the ratio; "
        "Coulomb friction of flanks, eccentric and output pins "
        "of the stage at the output, without seals, grease and a first stage, normal forces "
        "as without friction: rough above a fifth of the torque",
        samples=_AS_DRAWN,
    )
    return efficiency, _backdriving(drawn)


def _backdriving(drawn: ExaminedDrawing) -> Section:
    friction = drawn.friction
    known = friction.constant or friction.self_locking
    torque = _figure(friction.backdriving_torque if known else math.nan, "none", "not stated")
    stated = "friction_torque over what output pins leave; the input itself turns freely"
    unknown = "no friction without load is stated: state friction_torque"
    rows = [
        (
            "backdriving torque",
            torque,
            "self-locking" if friction.self_locking else stated if friction.constant else unknown,
        ),
        (
            "self-locking",
            _word(friction.self_locking),
            "yes where friction of eccentric or output pins takes all of a load, however large",
        ),
        (
            "the input turns the output",
            _word(friction.drives),
            "no where friction of the flanks takes all of its torque",
        ),
    ]
    note = (
        "without vibration, which may release a locked drive; as far as Coulomb friction of the "
        "stage goes, as above"
    )
    return table("backdriving", "Backdriving", ["value"], rows, note)


def _figure(value: float, infinite: str, missing: str = "") -> Cell:
    """Return a torque, or words in its place where it is infinite or missing."""
    words = "" if math.isfinite(value) else missing if math.isnan(value) else infinite
    return Cell(value, "N m", samples=_AS_DRAWN, words=words)


def _word(answer: bool) -> Cell:  # noqa: FBT001 - the answer itself
    return Cell(float(answer), "1", samples=_AS_DRAWN, words="yes" if answer else "no")


def friction_facts(drawn: ExaminedDrawing) -> dict[str, Any]:
    """Return what result.json holds of friction besides its figures; empty without stated
    friction.
    """
    friction = drawn.friction
    return (
        {"self_locking": friction.self_locking, "input_turns_output": friction.drives}
        if friction.any
        else {}
    )


def notes_on_friction(drawn: ExaminedDrawing, torque: float) -> Iterator[str]:
    """Yield the warnings on friction that is large, or takes all of the torque."""
    friction = drawn.friction
    if not friction.any:
        return
    if not friction.drives:
        yield (
            "friction of the flanks takes all of the torque: the input cannot turn the output, "
            "and a wound-up drive does not unload"
        )
    elif friction.driving(np.array(torque)) - torque > _LARGE * torque:
        yield (
            "friction is more than a fifth of the torque: loads are computed without it, so that "
            "efficiency and hysteresis are rough estimates"
        )
