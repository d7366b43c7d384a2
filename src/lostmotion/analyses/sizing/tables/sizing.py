"""The figures of an arm whose links were sized: the section of each, what its limits take, what other limits would cost, the look afresh."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, Final

import numpy as np

from lostmotion.analyses.sizing.sizing import PAPER
from lostmotion.error_model.provenance import states
from lostmotion.error_model.upper_limits import with_limits
from lostmotion.parts.family import said
from lostmotion.parts.section import Sized
from lostmotion.reporting.not_counted import NOT_COUNTED, without_mass
from lostmotion.reporting.provenance import at_least, caveats, provenance_facts, provenance_sections
from lostmotion.reporting.sheet import ARCMIN, Card, Figure, Row, Section, Sheet, length
from lostmotion.reporting.warnings import arm_warnings

if TYPE_CHECKING:
    from typing import Any

    from lostmotion.analyses.sizing.sizing import LinkSize, Sizing
    from lostmotion.error_model.provenance import States

_BINDS: Final = ("slope", "deflection")
# A limit taken by less than this is none that binds: the smallest section does.
_BINDING: Final = 0.97
# The point of the trade-off that the verdict tells of.
_WIDE: Final = 2.0
_WORDS: Final = (
    ("slope, deflection", "of the link's tip against its joint, across the link, under what hangs outboard and its own weight, at the worst pose."),
    ("binds", "the limit that is taken more: a lighter section would break it."),
    ("worst pose", "of the poses sampled, the corners of the joints' ranges, and those reached by climbing from the worst of both."),
    ("tool error, r.m.s.", "over the poses sampled: load, play, tolerances and all else, as exact sums over terms; nothing is drawn."),
    ("looked at afresh", "the sized arm at poses that the sizing did not see, by the law of bending that the study of an arm uses."),
)


def sizing_sheet(found: Sizing, notes: tuple[str, ...] = ()) -> Sheet:
    """What is there to say about an arm whose links were sized?"""
    given = f", {found.given} given" if found.given else ""
    known = with_limits(states(found.sized), found.sized, found.q)
    counted = f"{len(found.q)} poses: {len(found.poses)} {found.poses.law}{given}, {found.corners} corners, {_climbed(found)} climbed to"
    return Sheet(
        name=found.arm.name,
        subject="sections of its links",
        verdict=_verdict(found, known),
        cards=tuple(_cards(found)),
        sections=(_sections(found), _bending(found, counted), _loads(found), _trade(found), _afresh(found), *provenance_sections(known)),
        counts=counted + ("" if found.tilt is None else f", base tilted up to {math.degrees(found.tilt):.3g}°"),
        warnings=arm_warnings(found.sized),
        notes=(not_counted(found), *found.arm.remarks, *_remarks(found), *notes),
        words=_WORDS,
        source=f"{counted}. The same files, version, poses, seed and limits give the same bytes.",
        facts={**_facts(found), "not_counted": not_counted(found), **provenance_facts(known)},
    )


def _climbed(found: Sizing) -> int:
    return len(found.q) - len(found.poses) - found.given - found.corners


def _limits(found: Sizing) -> str:
    return f"slope {found.limits.slope / ARCMIN:.4g}', deflection length/{found.limits.deflection:.10g}"


def _kg(value: float, samples: str = "") -> Figure:
    return Figure(value, "kg", samples=samples)


def _arcmin(value: float, samples: str = "") -> Figure:
    return Figure(value / ARCMIN, "arcmin", samples=samples)


def section_said(section: Any) -> str:  # noqa: ANN401 - any section, or none
    """Name any section: by its sizes where it has some, else by its kind."""
    if section is None:
        return "no section"
    return said(section) if isinstance(section, Sized.__origin__) else str(section.kind)  # type: ignore[attr-defined]


def pose_said(found: Sizing, index: int) -> str:
    """Name a pose by its joint values, and say how it was come by."""
    parts = []
    for joint, value in zip(found.arm.moving, found.q[index], strict=True):
        parts.append(f"{joint.name} {math.degrees(value):.1f}°" if joint.type == "revolute" else f"{joint.name} {value * 1e3:.1f} mm")
    ends = np.cumsum([len(found.poses), found.given, found.corners])
    kind = ("sampled", "given", "corner", "climbed to")[int(np.searchsorted(ends, index, side="right"))]
    return f"{', '.join(parts)} ({kind})"


def _masses(found: Sizing) -> tuple[float, float]:
    return sum(link.mass_before for link in found.links), sum(link.mass for link in found.links)


def _missed(found: Sizing, link: LinkSize) -> str:
    """Say by how much the section that misses its limits by least misses them."""
    limit = f"{link.limits[0] / ARCMIN:.4g}'" if link.binds == 0 else str(length(link.limits[1], stated=True))
    value = f"{link.worst.slope / ARCMIN:.3g}'" if link.binds == 0 else str(length(link.worst.deflection))
    share = link.shares[link.binds]
    which = f"even {section_said(link.section)} has a {_BINDS[link.binds]} of {value}"
    return f"{link.joint}: {which}, {share:.3g} times its limit of {limit}, at {pose_said(found, link.index)}"


def _verdict(found: Sizing, known: States) -> str:
    before, after = _masses(found)
    failing = [link for link in found.links if not link.holds]
    if failing:
        return f"The limits cannot be held with the sections allowed ({_limits(found)}). {'; '.join(_missed(found, link) for link in failing)}."
    text = f"The links come to {_kg(after)}, now {_kg(before)}, with {_limits(found)} held at the worst pose of each."
    text += f" The r.m.s. tool error goes from {at_least(length(found.rms_before), known)} to {at_least(length(found.rms), known)}."
    if all(link.binds == 0 for link in found.links):
        text += " Slope binds at every link."
    wide = next(trade for trade in found.trade if trade.scale == _WIDE)
    if wide.holds and found.rms:
        more = 100 * (wide.rms / found.rms - 1)
        change = f"{abs(more):.2g} % {'larger' if more > 0 else 'smaller'}"
        text += f" Limits twice as wide would take {_kg(after - wide.mass)} more off the links and make the error {change}."
    return " ".join([text, *caveats(known)])


def _cards(found: Sizing) -> list[Card]:
    before, after = _masses(found)
    fullest = max(found.links, key=lambda link: max(link.shares))
    return [
        Card("links now", str(_kg(before)), "as stated"),
        Card("links sized", str(_kg(after)), "limits held" if found.holds else "limits not held"),
        Card("r.m.s. tool error", str(length(found.rms)), f"now {length(found.rms_before)}"),
        Card("fullest link", fullest.joint, f"{100 * max(fullest.shares):.3g} % of its {_BINDS[fullest.binds]}"),
    ]


def _sections(found: Sizing) -> Section:
    rows = [
        Row(link.joint, (_kg(link.mass_before), _kg(link.mass)), f"{section_said(link.before)} -> {section_said(link.section)}")
        for link in found.links
    ]
    rows.append(Row("all links sized", tuple(_kg(mass) for mass in _masses(found))))
    note = "what else is stated for a link's mass stays; sized from the tip inward, so every link carries the new ones outboard of it"
    return Section("sections", "Sections", ("mass now", "mass sized"), tuple(rows), note)


def _bending(found: Sizing, counted: str) -> Section:
    rows = []
    for link in found.links:
        slope, deflection = link.shares
        binds = _BINDS[link.binds] + " binds" if max(slope, deflection) > _BINDING else "neither binds: the smallest section, or the next in the list"
        if not link.holds:
            binds = f"{_BINDS[link.binds]} cannot be held"
        before = link.worst_before
        now = "rigid as stated" if before is None else f"now {before.slope / ARCMIN:.3g}' and {length(before.deflection)}"
        figures = (
            _arcmin(link.worst.slope, counted),
            Figure(100 * slope, "%", samples=counted),
            length(link.worst.deflection, samples=counted),
            Figure(100 * deflection, "%", samples=counted),
        )
        rows.append(Row(link.joint, figures, f"{binds}; {now}"))
    note = f"limits: {_limits(found)}. At the worst pose" + ("" if found.tilt is None else " and tilt of the base")
    return Section("bending", "Slope and deflection", ("slope", "of its limit", "deflection", "of its limit"), tuple(rows), note)


def _loads(found: Sizing) -> Section:
    rows = tuple(
        Row(link.joint, (Figure(link.force, "N"), Figure(link.moment, "N m"), Figure(link.own, "N")), pose_said(found, link.index))
        for link in found.links
    )
    note = "across the link, at its worst pose: where the limit that binds is taken most"
    return Section("loads", "Load on each link", ("force on the tip", "moment on the tip", "own weight"), rows, note)


def _trade(found: Sizing) -> Section:
    rows = []
    at_one = next(trade for trade in found.trade if trade.scale == 1)
    paper = found.limits == PAPER
    for trade in found.trade:
        limits = found.limits.scaled(trade.scale)
        note = "" if trade.holds else "not all limits can be held"
        if trade.scale == 1:
            note = "the paper's limits" if paper else "the limits asked for"
        figures = (
            _kg(trade.mass),
            Figure(100 * (trade.mass / at_one.mass - 1), "%"),
            length(trade.rms),
            Figure(100 * (trade.rms / at_one.rms - 1) if at_one.rms else math.nan, "%"),
        )
        rows.append(Row(f"{limits.slope / ARCMIN:.3g}', length/{limits.deflection:.0f}", figures, note))
    note = "both limits wider or narrower by the same factor, every link sized anew; error over the sampled poses by exact sums"
    return Section(
        "trade", "Mass against tool error", ("links", "against these limits", "r.m.s. tool error", "against these limits"), tuple(rows), note
    )


def _afresh(found: Sizing) -> Section:
    limits = {link.joint: link.limits for link in found.links}
    counted = f"{found.check_poses} poses not used in the sizing" if found.poses.law != "given" else f"the {found.check_poses} poses given"
    rows = []
    for bent in found.check:
        if bent.joint in limits:
            slope, deflection = bent.slope / limits[bent.joint][0], bent.deflection / limits[bent.joint][1]
            figures = (
                _arcmin(bent.slope, counted),
                Figure(100 * slope, "%", samples=counted),
                length(bent.deflection, samples=counted),
                Figure(100 * deflection, "%", samples=counted),
            )
            rows.append(Row(bent.joint, figures, "" if max(slope, deflection) <= 1 + 1e-6 else "beyond its limit"))
    note = "the base as it stands" + ("" if found.tilt is None else "; tilts are in the table above")
    return Section("afresh", "Looked at afresh", ("slope", "of its limit", "deflection", "of its limit"), tuple(rows), note)


def _remarks(found: Sizing) -> list[str]:
    out = []
    if found.kept:
        out.append(f"links left as they are: {', '.join(found.kept)}")
    added = [link.joint for link in found.links if link.before is None and link.mass_before]
    if added:
        out.append(f"links with a mass and no section as stated: {', '.join(added)}; that mass stays in full, and the section's comes on top")
    relieved = [f"{link.joint} by {', '.join(link.relieved_by)}" for link in found.links if link.relieved_by]
    if relieved:
        why = "where they bend most, links are relieved by the weight of others outboard, so that heavier ones might make them lighter"
        out.append(f"{why}: {'; '.join(relieved)}")
    if found.exceeded > 1 + 1e-6 and found.holds:
        out.append(f"looked at afresh a link takes {100 * found.exceeded:.3g} % of a limit: ask for more poses")
    return out


def _facts(found: Sizing) -> dict[str, Any]:
    return {
        "arm": found.arm.name,
        "limits": {"slope_rad": found.limits.slope, "length_over": found.limits.deflection},
        "tilt_rad": found.tilt,
        "holds": found.holds,
        "poses": {"sampled": len(found.poses), "law": found.poses.law, "given": found.given, "corners": found.corners, "climbed_to": _climbed(found)},
        "links": [
            {
                "joint": link.joint,
                "section": link.section.model_dump(),
                "mass_kg": link.mass,
                "mass_before_kg": link.mass_before,
                "slope_rad": link.worst.slope,
                "deflection_m": link.worst.deflection,
                "binds": _BINDS[link.binds],
                "holds": link.holds,
                "pose": found.q[link.index].tolist(),
            }
            for link in found.links
        ],
    }


def not_counted(found: Sizing) -> str:
    """Return what the sizing of links by limits does not count."""
    return (
        f"not counted: {NOT_COUNTED}, stresses and buckling of links, prices{without_mass(found.sized.unweighed)}; gearboxes, bearings and joint "
        "masses stay as they are, however light the links become"
    )
