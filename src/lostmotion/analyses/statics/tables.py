"""The figures of an arm that stands still: what every joint carries and by whose weight, which reducers do, where and how much the arm gives."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, Any, Final

import numpy as np

from lostmotion.catalogue.gearboxes import gearboxes
from lostmotion.catalogue.search import Wanted, figures_of, search
from lostmotion.error_model.provenance import NOT_DESCRIBED, states
from lostmotion.mechanism.load_causes import CAUSES
from lostmotion.reporting.provenance import at_least, caveats, provenance_facts, provenance_sections
from lostmotion.reporting.sheet import ARCMIN, Card, Figure, Row, Section, Sheet, length
from lostmotion.reporting.warnings import arm_warnings

if TYPE_CHECKING:
    from collections.abc import Sequence

    from lostmotion.analyses.statics.survey import Survey
    from lostmotion.catalogue.gearboxes import GearboxRow
    from lostmotion.error_model.provenance import States
    from lostmotion.mechanism.holding_torques import Asked, Node
    from lostmotion.spatial import Floats

_SHOWN: Final = 3
_DIRECTION_DIGITS: Final = 2
# A share of the softest direction's that is no more than what rounding leaves.
_NOTHING: Final = 1e-9
# By how much compliance may differ from its transpose before it is said.
_RECIPROCAL: Final = 0.01
_WORDS: Final = (
    ("holding torque", "what the drive holds against gravity and the process force while nothing moves; a force on a sliding joint."),
    ("tilted any way", "the worst over every direction that gravity could have in the base's axes: on a slope, on a wall, under a ceiling."),
    ("compliance", "how far the tool point moves per newton, here at the load that the arm carries anyway. Play is no compliance and left out."),
    ("principal direction", "a force along it moves the tool point along it and nowhere else. x, y, z are the base's."),
    ("turning held", "as for a tool that is guided and cannot turn; free: it turns as the force likes."),
    ("share", "of the compliance along a force, on average over all directions of the force. Shares add to 100 %."),
)


def statics_sheet(found: Survey, own: Sequence[GearboxRow] = ()) -> Sheet:
    """What is there to say about an arm that stands still? `own` are a user's reducers, which are looked through as well."""
    counted = f"{len(found.poses)} poses, {found.poses.law}"
    sections = [_torques(found, counted), _causes(found, counted), _reducers(found, own), _bearings(found, counted)]
    known = states(found.arm)
    if found.parts:
        sections += [_map(found, counted), _ellipsoid(found), _shares(found, counted)]
    return Sheet(
        name=found.arm.name,
        subject="statics and compliance",
        verdict=_verdict(found, known),
        cards=tuple(_cards(found)),
        sections=(*sections, *provenance_sections(known)),
        counts=counted + ("" if found.tilt is None else f", base tilted up to {_degrees(found.tilt)}"),
        warnings=arm_warnings(found.arm, found.poses),
        notes=(*found.arm.remarks, *_rigid(found), *_doubts(found)),
        words=_WORDS,
        source=f"{counted}. The same file, version, poses and tilt give the same bytes.",
        facts={
            "arm": found.arm.name,
            "poses": {"count": len(found.poses), "law": found.poses.law},
            "tilt_rad": found.tilt,
            **provenance_facts(known),
            **({"compliance_at_softest_pose": _matrix(found)} if found.parts else {}),
        },
    )


def _rigid(found: Survey) -> list[str]:
    """Name the parts whose compliance is not specified: none is neglected in silence."""
    if not found.parts:
        return ["every part is taken as rigid: there is no compliance to report"]
    arm = found.arm
    held = [joint.name for joint in arm.moving if joint.encoder is not None and joint.encoder.side == "output"]
    silent = {
        "gearboxes": [joint.name for joint in arm.moving if joint.name not in held and not _gives(found, f"joints.{joint.name}.gearbox")],
        "bearings": [joint.name for joint in arm.moving if not _gives(found, f"joints.{joint.name}.bearing")],
        "links": [joint.name for joint in arm.joints if joint.link.reach and not joint.link.rigid and not _gives(found, f"joints.{joint.name}.link")],
    }
    rigid = ([] if _gives(found, "base") else ["the base"]) + [f"{kind} of {', '.join(names)}" for kind, names in silent.items() if names]
    notes = [f"not specified and taken as rigid: {'; '.join(rigid)}"] if rigid else []
    return notes + ([f"gearboxes of {', '.join(held)} do not give: a controller with an encoder on the output holds them"] if held else [])


def _doubts(found: Survey) -> list[str]:
    """Say where the springs of bearings by drawing, read from a table, break reciprocity by more than they may."""
    worst = float(found.asymmetry.max()) if found.parts else 0.0
    if not worst > _RECIPROCAL:
        return []
    middle = float(np.median(found.asymmetry))
    said = f"compliance differs from its transpose by up to {100 * worst:.1f} %, at half of the poses by less than {100 * middle:.2g} %"
    return [f"{said}: the slopes of the bearings' tables are no surer than that, nor are the figures of compliance"]


def _gives(found: Survey, owner: str) -> bool:
    return any(part == owner or part.startswith(f"{owner} ") for part in found.parts)


def _degrees(angle: float) -> str:
    return f"{math.degrees(angle):.3g}°"


def _pose(found: Survey, index: int) -> str:
    """Name a pose by its number and joint values."""
    parts = []
    for joint, value in zip(found.arm.moving, found.poses.q[index], strict=True):
        parts.append(f"{joint.name} {math.degrees(value):.1f}°" if joint.type == "revolute" else f"{joint.name} {value * 1e3:.1f} mm")
    return f"pose {index}: {', '.join(parts)}"


def _matrix(found: Survey) -> dict[str, Any]:
    """Give the whole compliance where the arm is softest, for machines."""
    return {"pose": found.worst, "order": "rotation x y z, displacement x y z; rad and m per N m and N", "values": found.compliance.tolist()}


def _micro_per_newton(value: float, samples: str = "") -> Figure:
    return Figure(value * 1e6, "µm/N", samples=samples)


def _stiffness(value: float, samples: str = "") -> Figure:
    """Give what a compliance (m/N) is the inverse of, in the unit that suits its size."""
    if value > 1e-6:  # noqa: PLR2004 - where people change units
        return Figure(1e-3 / value, "N/mm", samples=samples)
    return Figure(1e-6 / value if value else math.inf, "N/µm", samples=samples)


def _verdict(found: Survey, known: States) -> str:
    turning = [node for node in found.nodes if node.unit == "N m"]
    said = []
    if turning:
        hardest = max(turning, key=lambda node: abs(node.needed.value))
        asked = hardest.needed
        how = f"with the base tilted by up to {_degrees(found.tilt)}" if found.tilt is not None else "whichever way the base is tilted"
        said.append(f"Joint {hardest.joint} holds the most: {Figure(abs(asked.value), 'N m')} {how}.")
    if found.parts:
        part = found.parts[int(found.worst_shares.argmax())].removeprefix("joints.")
        said.append(
            f"Where it is softest the arm gives {at_least(_micro_per_newton(float(found.softest[found.worst])), known)}; "
            f"{part} has {100 * found.worst_shares.max():.0f} % of it on average over directions."
        )
    if found.sag is not None and found.parts:
        said.append(f"The payload's weight moves the tool by up to {at_least(length(float(found.sag.max())), known)}.")
    return " ".join([*said, *(caveats(known) if known.described else [f"{NOT_DESCRIBED[0].upper()}{NOT_DESCRIBED[1:]}."])])


def _cards(found: Survey) -> list[Card]:
    out = []
    for node in sorted(found.nodes, key=lambda node: (node.unit, abs(node.needed.value)))[::-1][:2]:
        asked = node.needed
        within = "any tilt" if found.tilt is None else f"tilt up to {_degrees(found.tilt)}"
        out.append(Card(f"{node.joint} must hold", str(Figure(abs(asked.value), node.unit)), within))
    if found.parts:
        softest = float(found.softest[found.worst])
        out += [
            Card("softest direction", str(_micro_per_newton(softest)), f"pose {found.worst}"),
            Card("stiffness there", str(_stiffness(softest)), "tool free to turn"),
        ]
        middle = float(np.median(found.softest))
        out.append(Card("softest direction, half of the poses below", str(_micro_per_newton(middle))))
    if found.sag is not None and found.parts:
        out.append(Card("payload moves the tool", str(length(float(found.sag.max()))), f"at most, {found.arm.payload.mass:g} kg"))
    return out


def _cases(found: Survey, node: Node) -> list[tuple[str, Asked]]:
    tilted = [] if node.tilted is None or found.tilt is None else [(f"tilted up to {_degrees(found.tilt)}", node.tilted)]
    return [("as the base stands", node.standing), *tilted, ("tilted any way", node.anyhow)]


def _torques(found: Survey, counted: str) -> Section:
    rows = [
        Row(
            node.joint,
            tuple(
                Figure(asked.value if asked is node.standing else abs(asked.value), node.unit, samples=counted) for _, asked in _cases(found, node)
            ),
            _pose(found, node.needed.index) if abs(node.needed.value) > _NOTHING else "",
        )
        for node in found.nodes
    ]
    columns = tuple(name for name, _ in _cases(found, found.nodes[0]))
    last = columns[-1] if found.tilt is None else columns[1]
    note = (
        f"the worst of the poses visited, and exactly the worst over tilts; the pose named is that of '{last}'. As the base stands, the sign is "
        "the drive's. Acceleration is not in it"
    )
    return Section("torques", "Static torque that each drive must hold", columns, tuple(rows), note)


def _causes(found: Survey, counted: str) -> Section:
    met = [cause for cause in CAUSES if any(cause in node.standing.by_cause for node in found.nodes)]
    rows = []
    for node in found.nodes:
        for name, asked in _cases(found, node):
            if abs(asked.value) <= _NOTHING:
                continue
            sign = math.copysign(1.0, asked.value)
            figures = [Figure(sign * each, node.unit, samples=counted) for each in (asked.value, *(asked.by_cause[cause] for cause in met))]
            leaning = "" if asked is node.standing else f", leaning {_degrees(asked.tilt)}"
            rows.append(Row(f"{node.joint}, {name}", tuple(figures), f"pose {asked.index}{leaning}"))
    note = "a minus sign: that weight helps the drive. Leaning: how far the base leans then, of the sides that ask as much the lesser one"
    return Section("causes", "By whose weight", ("whole", *met), tuple(rows), note)


def _reducers(found: Survey, own: Sequence[GearboxRow]) -> Section:
    rows, silent = [], 0
    known = [*own, *gearboxes()]
    for joint, node in zip(found.arm.moving, found.nodes, strict=True):
        least = abs(node.needed.value)
        stated = joint.gearbox.rated_torque if joint.gearbox is not None else None
        rated = Figure(math.nan, "") if stated is None else Figure(float(stated), node.unit, stated=True)
        figures = (Figure(least, node.unit), rated)
        if node.unit != "N m":
            rows.append(Row(node.joint, figures, "slides: the catalogue rates reducers by torque"))
            continue
        answer = search(known, Wanted(min_torque=max(least, _NOTHING)))
        silent = len(answer.silent.get("rated torque", ()))
        fitting = sorted(answer.rows, key=lambda row: figures_of(row)["rated torque"])
        names = ", ".join(f"{_name(row)} ({figures_of(row)['rated torque']:.4g} N m)" for row in fitting[:_SHOWN])
        said = f"{len(fitting)} in the catalogue; the smallest: {names}" if fitting else "none in the catalogue is rated for it"
        weak = "the one stated is too weak; " if stated is not None and stated < least else ""
        rows.append(Row(node.joint, figures, weak + said))
    unrated = f". {silent} rows state no rated torque and are not among them" if silent else ""
    note = (
        f"static torque alone, at the worst {'tilt' if found.tilt is None else 'tilt asked for'}: acceleration, shocks and life come on top{unrated}"
    )
    return Section("reducers", "Reducers that carry it", ("needed", "rated, as stated"), tuple(rows), note)


def _name(row: GearboxRow) -> str:
    ratio = "" if row.ratio is None and row.ratio_above is None else f" ratio {row.ratios}"
    return f"{row.models[0]}{ratio}"


def _bearings(found: Survey, counted: str) -> Section:
    rows = [
        Row(
            node.joint,
            (
                Figure(_clean(node.moment), "N m", samples=counted),
                Figure(node.moment_anyhow, "N m", samples=counted),
                Figure(node.force, "N", samples=counted),
            ),
            f"poses {node.moment_index}, {node.moment_anyhow_index}, {node.force_index}",
        )
        for node in found.nodes
    ]
    process = any(found.arm.payload.force) or any(found.arm.payload.moment)
    note = "the moment that bends the joint's axis, all of it on a sliding joint; largest of the poses visited" + (
        ". Tilted any way: no more than this, for the process force turns with the arm" if process else ""
    )
    columns = ("moment, as the base stands", "moment, tilted any way", "force, as the base stands")
    return Section("bearings", "Static load on each joint's bearing", columns, tuple(rows), note)


def _clean(moment: float) -> float:
    return moment if moment > _NOTHING else 0.0


def _map(found: Survey, counted: str) -> Section:
    softest, stiffest = found.worst, int(found.softest.argmin())
    rows = [
        Row(label, (_micro_per_newton(value, counted), _stiffness(value, counted)), note)
        for label, value, note in (
            ("softest direction, softest pose", float(found.softest[softest]), _pose(found, softest)),
            ("softest direction, half of the poses below", float(np.median(found.softest)), ""),
            ("softest direction, stiffest pose", float(found.softest[stiffest]), _pose(found, stiffest)),
            ("mean over directions, softest pose", float(found.mean.max()), _pose(found, int(found.mean.argmax()))),
            ("mean over directions and poses", float(found.mean.mean()), ""),
        )
    ]
    section = Section(
        "map", "Where the arm gives", ("compliance", "stiffness"), tuple(rows), "tangent at the load that the arm carries; plays count as closed"
    )
    if found.sag is None:
        return section
    most = int(found.sag.argmax())
    said = (
        f"the payload's weight, {found.arm.payload.mass:g} kg, moves the tool by {length(float(found.sag.max()))} at most (pose {most}), "
        f"by {length(float(found.sag.mean()))} on average over the poses"
    )
    return Section(section.key, section.title, section.columns, section.rows, f"{section.note}; {said}")


def _ellipsoid(found: Survey) -> Section:
    counted = f"pose {found.worst}"
    rows = []
    for ellipsoid, what in ((found.free, "free to turn"), (found.held, "turning held")):
        for k, value in enumerate(ellipsoid.values[0]):
            axis = _direction(ellipsoid.directions[0, :, k])
            shown = float(value) if value > _NOTHING * found.free.values[0, 0] else 0.0
            rows.append(Row(f"{what}, {k + 1}", (_micro_per_newton(shown, counted), _stiffness(shown, counted)), f"along {axis}"))
    for k, value in enumerate(found.turning.values[0]):
        shown = float(value) if value > _NOTHING * found.turning.values[0, 0] else 0.0
        figures = (
            Figure(shown / ARCMIN, "arcmin/(N m)", samples=counted),
            Figure(ARCMIN / shown if shown else math.inf, "N m/arcmin", samples=counted),
        )
        rows.append(Row(f"turning under a moment, {k + 1}", figures, f"about {_direction(found.turning.directions[0, :, k])}"))
    note = f"principal directions at the softest pose, {_pose(found, found.worst)}"
    return Section("ellipsoid", "Compliance ellipsoid at the softest pose", ("compliance", "stiffness"), tuple(rows), note)


def _direction(axis: Floats) -> str:
    """Write a direction without a sense: the largest component points ahead."""
    ahead = axis * np.sign(axis[np.abs(axis).argmax()])
    return "(" + ", ".join(f"{each:.{_DIRECTION_DIGITS}f}" for each in np.round(ahead, _DIRECTION_DIGITS) + 0.0) + ")"


def _shares(found: Survey, counted: str) -> Section:
    order = np.argsort(-found.shares, kind="stable")
    here = f"pose {found.worst}"
    rows = tuple(
        Row(
            found.parts[k].removeprefix("joints."),
            (Figure(100 * float(found.shares[k]), "%", samples=counted), Figure(100 * float(found.worst_shares[k]), "%", samples=here)),
        )
        for k in order
    )
    return Section("shares", "Which part gives", ("mean over poses", "softest pose"), rows, "of the compliance along a force, all directions alike")
