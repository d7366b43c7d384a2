"""Page of an arm with sized links: sections, utilisation of the limits, loads, trade-off and
validation. That of selected parts stands beside it.
"""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, Final

import numpy as np

from lostmotion.analyses.sizing.page.plots import sizing_plots as plots
from lostmotion.error_model.upper_limits import with_limits
from lostmotion.parts.family import section_text
from lostmotion.printed import ARCMIN
from lostmotion.reporting.arm_sheet import sections_as_known, with_arm
from lostmotion.reporting.joint_values import joint_values
from lostmotion.reporting.not_counted import NOT_COUNTED, without_mass
from lostmotion.reporting.provenance import as_known, assumed_drives_sentences, at_least, caveats
from lostmotion.reporting.sheet import Card, Cell, Section, Sheet, length, several, table
from lostmotion.sizing.lightest import PAPER

if TYPE_CHECKING:
    from typing import Any

    from lostmotion.analyses.sizing.sizing import Size
    from lostmotion.error_model.provenance import States
    from lostmotion.sizing.links import LinkSize

_GOVERNING: Final = ("slope", "deflection")
_OF_LIMITS: Final = ("slope", "utilisation", "deflection", "utilisation")
# Below this utilisation no limit governs: the smallest section is enough.
_GOVERNS: Final = 0.97
# The point of the trade-off in the verdict.
_WIDE: Final = 2.0
__all__ = ["plots", "sheet"]
_WORDS: Final = (
    (
        "slope, deflection",
        (
            "of the link's tip relative to its joint, across the link, under its own weight and "
            "all load outboard, at the worst pose."
        ),
    ),
    ("governing", "the limit with the larger utilisation: a lighter section would exceed it."),
    (
        "worst pose",
        (
            "of the sampled poses, the corners of the joint ranges, and worse poses result by "
            "local search."
        ),
    ),
    (
        "tool error, r.m.s.",
        "over the sampled poses, of all error sources, by exact sums over terms.",
    ),
    (
        "validation",
        "the sized arm at poses that were not used in the sizing, with the beam model of a study.",
    ),
)


def sheet(result: Size) -> Sheet:
    """Return the sheet of an arm with sized links."""
    given = f", {result.given} given" if result.given else ""
    known = with_limits(result.states, result.sized, result.q)
    sources = (
        f"{len(result.poses)} {result.poses.law}{given}, {result.corners} corners, "
        f"{_searched(result)} by local search"
    )
    counted = f"{several(len(result.q), 'pose')}: {sources}"
    tilts = "" if result.tilt is None else f", base tilt up to {math.degrees(result.tilt):.3g}°"
    return with_arm(
        Sheet(
            subject="sections of its links",
            verdict=_verdict(result, known),
            cards=tuple(_cards(result, known)),
            sections=(
                _sections(result),
                _bending(result, counted),
                _loads(result),
                *sections_as_known([_trade_off(result)], known),
                _validation(result),
            ),
            counts=counted + tilts,
            notes=tuple(_remarks(result)),
            words=_WORDS,
            source=(
                f"{counted}. The same files, version, poses, seed and limits give the same bytes."
            ),
            facts=_facts(result),
        ),
        result.sized,
        known,
        not_counted=not_counted(result),
    )


def _searched(result: Size) -> int:
    return len(result.q) - len(result.poses) - result.given - result.corners


def _limits(result: Size) -> str:
    return (
        f"slope {result.limits.slope / ARCMIN:.4g} arcmin, deflection "
        f"length/{result.limits.deflection:.10g}"
    )


def _kg(value: float) -> Cell:
    return Cell(value, "kg")


def pose_name(result: Size, index: int) -> str:
    """Return the joint values of a pose and its origin as text."""
    ends = np.cumsum([len(result.poses), result.given, result.corners])
    kind = ("sampled", "given", "corner", "local search")[
        int(np.searchsorted(ends, index, side="right"))
    ]
    return f"{joint_values(result.arm, result.q[index])} ({kind})"


def _masses(result: Size) -> tuple[float, float]:
    return sum(link.mass_before for link in result.links), sum(link.mass for link in result.links)


def _excess(result: Size, link: LinkSize) -> str:
    """Return by how much the section of least utilisation exceeds the governing limit, as text."""
    limit = (
        f"{link.limits[0] / ARCMIN:.4g} arcmin"
        if link.governing == 0
        else str(length(link.limits[1], stated=True))
    )
    value = (
        f"{link.worst.slope / ARCMIN:.3g} arcmin"
        if link.governing == 0
        else str(length(link.worst.deflection))
    )
    share = link.utilisation[link.governing]
    name = f"even {section_text(link.section)} has a {_GOVERNING[link.governing]} of {value}"
    return (
        f"{link.joint}: {name}, {share:.3g} times its limit of {limit}, at "
        f"{pose_name(result, link.index)}"
    )


def _verdict(result: Size, known: States) -> str:
    before, after = _masses(result)
    failing = [link for link in result.links if not link.meets_limits]
    if failing:
        return (
            f"No allowed section meets the limits ({_limits(result)}). "
            f"{'; '.join(_excess(result, link) for link in failing)}."
        )
    one = len(result.links) == 1
    sized, at = ("link", "its worst pose") if one else ("links", "the worst pose of each")
    text = (
        f"The mass of the sized {sized} is {_kg(after)}, as stated {_kg(before)}; "
        f"{_limits(result)} are met at {at}."
    )
    text += (
        f" The r.m.s. tool error changes from {at_least(length(result.rms_error_before), known)} "
        f"to {at_least(length(result.rms_error), known)}."
    )
    if all(link.governing == 0 for link in result.links):
        text += (
            f" Slope governs {f'the link of {result.links[0].joint}' if one else 'at every link'}."
        )
    wide = next(point for point in result.trade_off if point.scale == _WIDE)
    if wide.meets_limits and result.rms_error:
        more = 100 * (wide.rms_error / result.rms_error - 1)
        change = f"{abs(more):.2g} % {'larger' if more > 0 else 'smaller'}"
        text += (
            f" With limits twice as wide the {sized} {'is' if one else 'are'} "
            f"{_kg(after - wide.mass)} lighter and the error is {change}."
        )
    return " ".join([text, *assumed_drives_sentences(known), *caveats(known, missing=False)])


def _cards(result: Size, known: States) -> list[Card]:
    before, after = _masses(result)
    noun = "link" if len(result.links) == 1 else "links"
    critical = max(result.links, key=lambda link: max(link.utilisation))
    return [
        Card(f"{noun} as stated", str(_kg(before))),
        Card(
            f"{noun} sized",
            str(_kg(after)),
            "limits met" if result.meets_limits else "limits not met",
        ),
        Card(
            "r.m.s. tool error",
            str(as_known(length(result.rms_error), known)),
            f"as stated {at_least(length(result.rms_error_before), known)}",
            limited_as="error",
        ),
        Card(
            f"highest utilisation, {critical.joint}",
            f"{100 * max(critical.utilisation):.3g} %",
            f"of its {_GOVERNING[critical.governing]}",
        ),
    ]


def _sections(result: Size) -> Section:
    rows = [
        *(
            (
                link.joint,
                link.mass_before,
                link.mass,
                f"{section_text(link.before)} -> {section_text(link.section)}",
            )
            for link in result.links
        ),
        ("total", *_masses(result)),
    ]
    note = (
        "free sizes are usual ones of tubes, bars and profiles, or multiples of the step that "
        "was asked for; additional stated mass of a link is "
        "unchanged; sized from the tip inward, so every link carries the new ones outboard of it"
    )
    return table("sections", "Sections", ["mass now", "mass sized"], rows, note, unit="kg")


def _of_limits(
    slope: float, deflection: float, utilisation: tuple[float, float]
) -> tuple[Cell, Cell, Cell, Cell]:
    """Return slope and deflection, each with its share of its limit."""
    return (
        Cell(slope, "arcmin"),
        Cell(utilisation[0], "%"),
        length(deflection),
        Cell(utilisation[1], "%"),
    )


def _bending(result: Size, counted: str) -> Section:
    rows = []
    for link in result.links:
        name, before = _GOVERNING[link.governing], link.worst_before
        governing = (
            f"{name} cannot be met"
            if not link.meets_limits
            else "no limit governs: the smallest section, or the next in the list"
            if max(link.utilisation) <= _GOVERNS
            else f"{name} governs"
        )
        now = (
            "rigid as stated"
            if before is None
            else f"as stated {before.slope / ARCMIN:.3g} arcmin and {length(before.deflection)}"
        )
        figures = _of_limits(link.worst.slope, link.worst.deflection, link.utilisation)
        rows.append((link.joint, *figures, f"{governing}; {now}"))
    note = f"limits: {_limits(result)}. At the worst pose" + (
        "" if result.tilt is None else " and tilt of the base"
    )
    return table("bending", "Slope and deflection", _OF_LIMITS, rows, note, samples=counted)


def _loads(result: Size) -> Section:
    return table(
        "loads",
        "Load on each link",
        {"force on the tip": "N", "moment on the tip": "N m", "own weight": "N"},
        (
            (link.joint, link.force, link.moment, link.own_weight, pose_name(result, link.index))
            for link in result.links
        ),
        "across the link, at the worst pose of the governing limit",
    )


def _trade_off(result: Size) -> Section:
    rows = []
    at_one = next(point for point in result.trade_off if point.scale == 1)
    for point in result.trade_off:
        limits = result.limits.scaled(point.scale)
        note = "" if point.meets_limits else "not all limits can be met"
        if point.scale == 1:
            note = "the paper's limits" if result.limits == PAPER else "the stated limits"
        rows.append(
            (
                f"{limits.slope / ARCMIN:.3g} arcmin, length/{limits.deflection:.0f}",
                _kg(point.mass),
                Cell(point.mass / at_one.mass - 1, "%"),
                length(point.rms_error),
                Cell(point.rms_error / at_one.rms_error - 1 if at_one.rms_error else math.nan, "%"),
                note,
            )
        )
    return table(
        "trade",
        "Mass against tool error",
        ["links", "difference", "r.m.s. tool error", "difference"],
        rows,
        "both limits scaled by the same factor, every link sized again; error over the sampled "
        "poses by exact sums",
    )


def _validation(result: Size) -> Section:
    limits = {link.joint: link.limits for link in result.links}
    counted = (
        f"{several(result.validation_poses, 'pose')} not used in the sizing"
        if result.poses.law != "given"
        else f"the {result.validation_poses} poses given"
    )
    rows = []
    for link in result.validation:
        if link.joint in limits:
            slope, deflection = limits[link.joint]
            utilisation = link.slope / slope, link.deflection / deflection
            figures = _of_limits(link.slope, link.deflection, utilisation)
            exceeds = "" if max(utilisation) <= 1 + 1e-6 else "exceeds its limit"
            rows.append((link.joint, *figures, exceeds))
    note = "base as stated" + ("" if result.tilt is None else "; the table above includes tilts")
    return table("validation", "Validation", _OF_LIMITS, rows, note, samples=counted)


def _remarks(result: Size) -> list[str]:
    out = []
    if result.sized.soft_freedoms:
        out.append(
            "the arm droops: links are sized for the loads at the command; the r.m.s. errors are "
            "those where it stands"
        )
    if result.unchanged:
        out.append(f"links not sized: {', '.join(result.unchanged)}")
    added = [link.joint for link in result.links if link.before is None and link.mass_before]
    if added:
        out.append(
            f"links with a mass and no section as stated: {', '.join(added)}; the section is "
            "added to that mass"
        )
    relieved = [
        f"{link.joint} by {', '.join(link.relieved_by)}"
        for link in result.links
        if link.relieved_by
    ]
    if relieved:
        why = (
            "at their worst pose, links are relieved by the weight of others outboard; heavier "
            "ones might make them lighter"
        )
        out.append(f"{why}: {'; '.join(relieved)}")
    if result.validated_utilisation > 1 + 1e-6 and result.meets_limits:
        out.append(
            f"at the validation poses a link reaches {100 * result.validated_utilisation:.3g} "
            "% of a limit: use more poses"
        )
    return out


def _facts(result: Size) -> dict[str, Any]:
    return {
        "limits": {"slope_rad": result.limits.slope, "length_over": result.limits.deflection},
        "tilt_rad": result.tilt,
        "holds": result.meets_limits,
        "poses": {
            "sampled": len(result.poses),
            "law": result.poses.law,
            "given": result.given,
            "corners": result.corners,
            "climbed_to": _searched(result),
        },
        "links": [
            {
                "joint": link.joint,
                "section": link.section.model_dump(),
                "mass_kg": link.mass,
                "mass_before_kg": link.mass_before,
                "slope_rad": link.worst.slope,
                "deflection_m": link.worst.deflection,
                "binds": _GOVERNING[link.governing],
                "holds": link.meets_limits,
                "pose": result.q[link.index].tolist(),
            }
            for link in result.links
        ],
    }


def not_counted(result: Size) -> str:
    """Return what the sizing of links does not count."""
    massless = without_mass(result.sized.gearboxes_without_mass)
    return (
        f"not counted: {NOT_COUNTED}, stresses and buckling of links, prices{massless}; gearboxes, "
        "bearings and joint masses are unchanged"
    )
