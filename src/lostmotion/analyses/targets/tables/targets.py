"""The figures of a target: how large each item may be, one at a time and all together, which are out of reach, and how many robots keep it."""

from __future__ import annotations

import math
from dataclasses import replace
from typing import TYPE_CHECKING, Final

import numpy as np

from lostmotion.analyses.targets.tables.sizes import exactly, now_sized, sized, times, usual_limit
from lostmotion.analyses.targets.tables.yield_ import allocated, allocated_section, yield_facts, yield_figure, yield_section
from lostmotion.error_model.provenance import states
from lostmotion.error_model.upper_limits import with_limits
from lostmotion.reporting.provenance import at_least, caveats, provenance_facts, provenance_sections, repeats_bounded
from lostmotion.reporting.sheet import Card, Figure, Row, Section, Sheet, length, several
from lostmotion.reporting.warnings import arm_warnings

if TYPE_CHECKING:
    from collections.abc import Iterable, Sequence
    from typing import Any

    from lostmotion.analyses.targets.allocation import Joint
    from lostmotion.analyses.targets.parameters import Item
    from lostmotion.analyses.targets.targets import Allowed, Targets
    from lostmotion.error_model.intervals import Estimate
    from lostmotion.error_model.provenance import States

# An item that takes less off, were it not there, is only counted.
_TELLING: Final = 0.002
_NAN: Final = math.nan
_NOT_LIMITING: Final = "not limiting"
_WORDS: Final = (
    ("item", "one cause in one part: the play of a gearbox, a bearing's clearance, a link's stiffness. Its ± goes along in proportion."),
    ("factor", "on the item's errors. A stiffness goes with one over it: twice the error is half the stiffness."),
    ("one at a time", "all other items stay as they are, and so do loads and masses."),
    ("equal factor", "all errors larger or smaller by the same factor."),
    ("equal effect", "sizes with which every item has the same part of the mean square: none is better made than the others deserve."),
    (
        "not limiting",
        "even the coarsest usual size meets it: 60' of play, 100 counts per turn, 200 µm of clearance, 1 % of a length, a tenth of a stiffness.",
    ),
    (
        "share",
        "of the mean square as things are, for repeatability of what differs between visits. Shares add to 100 %; a negative one cancels others.",
    ),
    ("yield", "share of the robots built that keep the target, each judged by its own figure; its interval is exact and counts robots."),
    ("verified", "by the Monte Carlo of the study with the sizes told here, and draws of its own."),
)


def targets_sheet(found: Targets) -> Sheet:
    """What is there to say about a target?"""
    where = f" in {found.zone}" if found.zone else ""
    counted = f"{several(found.robots, 'robot')} x {several(found.visits, 'visit')} x {several(len(found.poses), 'pose')}{where}, seed {found.seed}"
    yields = (yield_section(found, _target(found)), *allocated_section(found, _target(found)))
    sections = [_whole(found), *_single(found), *_kinds(found), *_none(found), *_usual(found), *_any(found), *_together(found), *yields]
    known = with_limits(states(found.arm), found.arm, found.poses.q, found.approach)
    return Sheet(
        name=found.arm.name,
        subject="what a target asks of its parts",
        verdict=_verdict(found, known),
        cards=tuple(_cards(found)),
        sections=(*sections, *provenance_sections(known)),
        counts=counted,
        warnings=arm_warnings(found.arm),
        notes=(*found.arm.remarks, *_remarks(found)),
        words=_WORDS,
        source=f"seed {found.seed}: {counted}, {found.poses.law}. The same arm, version, seed, counts and target give the same bytes.",
        seed=found.seed,
        facts={**_facts(found), **provenance_facts(known)},
    )


def kept(found: Targets) -> bool:
    """Tell whether the target is kept as things are."""
    return found.now.value <= found.target


def what(found: Targets) -> str:
    """Name what is held against the target."""
    share = f"{100 * found.share:g} %"
    where = f" in {found.zone}" if found.zone else ""
    return f"error, {share} of positions{where}" if found.kind == "error" else f"RP, {share} of robots{where}"


def ordered(allowed: Iterable[Allowed]) -> list[Allowed]:
    """Put those with a size first that leave least, or ask for most."""
    return sorted((each for each in allowed if each.verdict == "sized"), key=lambda each: each.factor.value)


def _of(estimate: Estimate, samples: str = "") -> Figure:
    return length(estimate.value, estimate.low, estimate.high, samples)


def _solved(found: Targets) -> str:
    if found.kind == "error":
        return f"{several(found.solved_samples, 'sample')} at {several(found.solved_poses, 'pose')}, each a robot and a visit of its own"
    return f"{several(found.solved_samples, 'sample')}: robots x visits x {several(found.solved_poses, 'pose')}"


def _verified(found: Targets) -> str:
    return f"{several(found.robots, 'robot')} x {several(found.verified_visits, 'visit')} x {several(len(found.poses), 'pose')} ({found.poses.law})"


def _whole(found: Targets) -> Section:
    rows = [
        Row("target", (_target(found),), f"{what(found)}; {'kept' if kept(found) else 'missed'} as things are"),
        Row("as things are", (_of(found.now, _verified(found)),)),
        Row("as things are, by the samples that sized", (_of(found.now_by_gauge, _solved(found)),), "two ways, to be compared"),
    ]
    for name, joint in (("equal factor", found.equal_factor), ("equal effect", found.equal_effect)):
        if joint is not None:
            rows.append(Row(f"sized by {name}", (_of(joint.verified, _verified(found)),), "verified: all items together, sizes below"))
    return Section("target", "Target", ("value",), tuple(rows))


def _single(found: Targets) -> list[Section]:
    note = "all else as it is; tightest first. Last: error or RP with that size, by Monte Carlo. A ? ends an interval where perhaps no size does"
    return _sized_section(found, "single", "One item at a time", found.single, note)


def _kinds(found: Targets) -> list[Section]:
    note = "the same cause in all parts of a kind, all else as it is; a size is told where all have the same"
    return _sized_section(found, "kinds", "One cause in all parts of a kind", found.kinds, note)


def _sized_section(found: Targets, key: str, title: str, allowed: Sequence[Allowed], note: str) -> list[Section]:
    rows = []
    for each in ordered(allowed):
        then = Figure(_NAN, "mm") if each.verified is None else _of(each.verified, _verified(found))
        allows = sized(each.item, each.factor)
        figures = (Figure(allows.value, allows.unit, allows.low, allows.high, _solved(found)), then)
        rows.append(Row(each.item.name, figures, _note(each)))
    return [Section(key, title, ("allowed", "verified"), tuple(rows), note)] if rows else []


def _note(each: Allowed) -> str:
    if each.item.size is not None:
        said = [f"now {now_sized(each.item)}; errs {times(each.factor.value)} as much"]
    elif "stiffness" in each.item.cause:
        said = [f"of its stiffness now; errs {times(each.factor.value)} as much"]
    else:
        said = ["of its errors now"]
    if each.item.size is not None and each.item.size.zones > 1:
        said.append(f"first of {each.item.size.zones} zones, all alike")
    if len(each.ranges) > 1 or each.ranges[0][0] > 0:
        spans = " and ".join(f"{low:.3g} to {'any' if math.isinf(high) else f'{high:.3g}'}" for low, high in each.ranges)
        said.append(f"it cancels others: only factors from {spans} meet the target")
    return "; ".join(said)


def _none(found: Targets) -> list[Section]:
    alone = sorted((each for each in (*found.single, *found.kinds) if each.verdict == "none"), key=lambda each: each.without.value)
    telling = [each for each in alone if each.without.value < (1 - _TELLING) * found.now_by_gauge.value]
    rows = []
    for each in telling:
        figures = (now_sized(each.item), _of(each.without, _solved(found)), Figure(100 * each.share, "%", samples=_exact(found)))
        rows.append(Row(each.item.name, figures, ""))
    note = f"without it, by a size of nothing or a stiffness without end, the rest is already more than the target of {_target(found)}"
    others = len(alone) - len(telling)
    if others:
        note += f". So it is for {others} more, which make less than {100 * _TELLING:g} % of a difference"
    columns = ("now", "the rest is already", "share")
    return [Section("none", "No size of this alone meets the target", columns, tuple(rows), note)] if alone else []


def _exact(found: Targets) -> str:
    return f"exact sum over terms, {several(len(found.poses), 'pose')}"


def _any(found: Targets) -> list[Section]:
    """List what may be of any size, the parts of a kind in one row."""
    groups: dict[tuple[str, str], list[Allowed]] = {}
    for each in found.single:
        if each.verdict == "any":
            groups.setdefault((each.item.kind, each.item.cause), []).append(each)
    rows = []
    for (kind, cause), members in groups.items():
        names = ", ".join(_where(each.item) for each in members)
        rows.append(Row(f"{kind} {cause}", (Figure(100 * sum(each.share for each in members), "%", samples=_exact(found)),), names))
    note = "they do not move the tool, or so seldom that the target is kept all the same"
    if found.kind == "repeatability":
        note = "they move every visit of a robot alike, or not at all"
    return [Section("any", "Any size meets the target", ("share",), tuple(rows), note)] if rows else []


def _usual(found: Targets) -> list[Section]:
    """List what meets the target at every usual size, the parts of a kind in one row."""
    groups: dict[tuple[str, str, float], list[Allowed]] = {}
    for each in (*found.single, *found.kinds):
        if each.verdict == "usual":
            limit = usual_limit(each.item).value
            groups.setdefault((each.item.kind, each.item.cause, limit) if each in found.single else (each.item.name, "", limit), []).append(each)
    rows = []
    for (kind, cause, _), members in groups.items():
        names = ", ".join(_where(each.item) for each in members) if cause else "all of them"
        share = Figure(100 * sum(each.share for each in members), "%", samples=_exact(found))
        rows.append(Row(f"{kind} {cause}".strip(), (usual_limit(members[0].item), share), names))
    note = f"{_NOT_LIMITING}: any usual value will do. The largest usual size meets the target too, all else as it is"
    return [Section("usual", "Not limiting: any usual value meets the target", ("usual up to", "share"), tuple(rows), note)] if rows else []


def _where(item: Item) -> str:
    """Name the joint of an item, or the base."""
    return item.owner.removeprefix("joints.").rpartition(".")[0] or "base"


def _together(found: Targets) -> list[Section]:
    factor, effect = found.equal_factor, found.equal_effect
    if factor is None:
        return []
    rows = []
    shares = {each.item.name: each.share for each in found.single}
    for k, item in sorted(enumerate(found.items), key=lambda one: -shares[one[1].name]):
        if np.isfinite(factor.factors[k]):
            figures = (
                now_sized(item),
                sized(item, exactly(float(factor.factors[k]))),
                _of_equal_effect(item, k, effect),
            )
            share = Figure(100 * shares[item.name], "%", samples=_exact(found))
            said = "" if item.size is not None else f"of its {'stiffness' if 'stiffness' in item.cause else 'errors'} now"
            rows.append(Row(item.name, (*figures, share), said))
    of = "the mean square" if found.kind == "error" else "what differs between visits"
    note = f"share: of {of}, as things are; {_joint_note(factor, effect)}"
    return [Section("together", "All items together", ("now", "equal factor", "equal effect", "share"), tuple(rows), note)]


def _of_equal_effect(item: Item, k: int, effect: Joint | None) -> Figure:
    if effect is None:
        return Figure(_NAN, "1")
    size = sized(item, exactly(float(effect.factors[k])))
    return replace(size, value=_NAN, words=_NOT_LIMITING) if effect.usual[k] else size


def _joint_note(factor: Joint, effect: Joint | None) -> str:
    said = f"equal factor: {float(np.nanmax(factor.factors)):.3g} on all errors, {_sure(factor)}"
    if effect is None:
        return f"{said}. No sizes have equal effect: items cancel each other whatever their size"
    others = np.isfinite(effect.factors) & ~effect.usual
    if not others.any():
        return f"{said}. Equal effect: every item may have its largest usual size"
    each = float(np.sqrt(effect.parts[others].mean()))
    rest = f"; {_NOT_LIMITING}: any usual value will do, counted at the largest" if effect.usual.any() else ""
    return f"{said}. Equal effect: {length(each)} r.m.s. from each, {_sure(effect)}{rest}"


def _sure(joint: Joint) -> str:
    """Say how sure the sizes of all items together are, as a share of them."""
    wide = joint.value.half / joint.value.value
    return f"sure to {100 * wide:.1g} %" if math.isfinite(wide) else "for which so few robots have no interval"


def _target(found: Targets) -> Figure:
    return length(found.target, stated=True)


def _verdict(found: Targets, known: States) -> str:
    now = f"{_of(found.now)}{f' ({_of(found.now).interval})' if _of(found.now).interval else ''}"
    said = (
        f"{100 * found.share:g} % of positions are within {at_least(now, known)}"
        if found.kind == "error"
        else f"{100 * found.share:g} % of robots repeat within {repeats_bounded(now, known)}"
    )
    said += f": the target of {_target(found)} is {'kept' if kept(found) else 'missed'}."
    if found.equal_factor is not None:
        factor = float(np.nanmax(found.equal_factor.factors))
        said += f" All errors {'may grow' if factor > 1 else 'must shrink'} to {factor:.3g} of what they are, all alike."
    single = ordered(found.single)
    if kept(found) and single:
        one = single[0]
        said += f" The tightest item is {one.item.name}, now {now_sized(one.item)}, allowed {_plain(one)}."
    elif single:
        alone = ", ".join(f"{each.item.name} ({now_sized(each.item)} to {_plain(each)})" for each in reversed(single[-2:]))
        said += f" One item alone would do, the easiest: {alone}."
    elif not kept(found):
        rest = min((each.without.value for each in found.single), default=found.now.value)
        said += f" No single item meets it: the rest is already {length(rest)} at best."
        if kinds := ordered(found.kinds):
            said += f" One cause in all parts of a kind would do: {kinds[-1].item.name} ({now_sized(kinds[-1].item)} to {_plain(kinds[-1])})."
    first = yield_figure(found.yields[0])
    said += f" {first} of the robots built keep it ({first.interval})."
    if found.equal_effect is not None:
        then = yield_figure(found.equal_effect.yields[0])
        said += f" With the sizes of equal effect {then} would ({then.interval})."
    return " ".join([said, *caveats(known)])


def _plain(each: Allowed) -> Figure:
    """Give the allowed size to three digits or so, without an interval."""
    figure = sized(each.item, each.factor)
    return Figure(figure.value, figure.unit)


def _cards(found: Targets) -> list[Card]:
    now = _of(found.now)
    out = [
        Card("target", str(_target(found)), what(found)),
        Card("as things are", str(now), f"interval {now.interval}" if now.interval else ""),
    ]
    if found.equal_factor is not None:
        factor = float(np.nanmax(found.equal_factor.factors))
        out.append(Card("all errors alike may be", times(factor), "what they are now"))
    single = ordered(found.single)
    if single:
        one = single[0] if kept(found) else single[-1]
        out.append(Card("tightest item" if kept(found) else "easiest item alone", str(_plain(one)), f"{one.item.name}, now {now_sized(one.item)}"))
    if found.equal_effect is not None:
        figure = yield_figure(found.equal_effect.yields[0])
        out.append(Card("robots that keep it, sizes of equal effect", str(figure), f"interval {figure.interval}"))
    for each, title in zip(found.yields, ("robots that keep it", "at every pose"), strict=True):
        figure = yield_figure(each)
        out.append(Card(title, str(figure), f"interval {figure.interval}"))
    return out


def _remarks(found: Targets) -> list[str]:
    out = []
    far = [each.item.name for each in found.single if each.verified is not None and not _meets(found, each)]
    if far:
        out.append(f"Monte Carlo does not confirm these sizes to its own interval: {', '.join(far)}; ask for more poses and robots")
    if any(each.item.kind == "gearbox" and each.item.cause == "play" and each.item.size is None for each in found.single):
        out.append("play by drawing is told as a factor on it: which dimensions make it, `lostmotion gear` tells")
    return out


def _meets(found: Targets, each: Allowed) -> bool:
    """Tell whether the verified value agrees with the target: within its interval, and within that of the factor."""
    checked, factor = each.verified, each.factor
    if checked is None or not all(math.isfinite(end) for end in (checked.low, checked.high, factor.low, factor.high)):
        return True
    spare = checked.half + found.target * (factor.high - factor.low) / 2 / factor.value
    return abs(checked.value - found.target) <= spare


def _facts(found: Targets) -> dict[str, Any]:
    def told(each: Allowed) -> dict[str, Any]:
        size = each.item.size
        finite = each.verdict == "sized"
        return {
            "part": each.item.owner.rstrip(","),
            "cause": each.item.cause,
            "verdict": each.verdict,
            "factor": each.factor.value if finite else None,
            "unit": None if size is None else size.unit,
            "now": None if size is None else size.value,
            "allowed": size.at(each.factor.value) if size is not None and finite else None,
            "factor_ranges": [[low, high if math.isfinite(high) else None] for low, high in each.ranges],
            "without_m": each.without.value if each.verdict == "none" else None,
            "largest_usual": each.item.size.at(each.item.most) if each.item.size is not None else None,
            "share_of_mean_square": each.share,
        }

    def all_of(joint: Joint | None) -> dict[str, Any] | None:
        if joint is None:
            return None
        sizes = zip(found.items, joint.factors.tolist(), joint.parts.tolist(), joint.usual.tolist(), strict=True)
        return {
            item.name: {"factor": None if usual else factor, "mean_square_m2": part, "not_limiting": usual}
            for item, factor, part, usual in sizes
            if math.isfinite(factor)
        }

    return {
        "arm": found.arm.name,
        "target": {"of": found.kind, "value_m": found.target, "share": found.share, "kept": kept(found)},
        "seed": found.seed,
        "poses": {"count": len(found.poses), "law": found.poses.law, "zone": found.zone},
        "robots": found.robots,
        "visits": found.visits,
        "items": [told(each) for each in found.single],
        "kinds": [told(each) for each in found.kinds],
        "equal_factor": all_of(found.equal_factor),
        "equal_effect": all_of(found.equal_effect),
        "yield": yield_facts(found.yields),
        "yield_allocated": {name: yield_facts(joint.yields) for name, joint in allocated(found)},
    }
