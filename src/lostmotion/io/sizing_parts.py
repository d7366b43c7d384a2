"""Parts that a sizing file offers for a joint: gearboxes and bearing clearances, with their masses
and prices.
"""

from __future__ import annotations

import math
from dataclasses import replace
from typing import TYPE_CHECKING, Any, Final

from pydantic import ValidationError

from lostmotion.catalogue.clearances import clearance_of_group
from lostmotion.catalogue.gearboxes import find_gearbox, find_rows, gearboxes
from lostmotion.error_model.poses import sample_poses
from lostmotion.errors import InputError, shown
from lostmotion.io.clearances import TABLES
from lostmotion.io.limits import listed
from lostmotion.io.sizing_options import (
    BEARING_EXAMPLE,
    COST_EXAMPLE,
    GEARBOX_EXAMPLE,
    PRESENT,
    option_key,
    present_example,
)
from lostmotion.io.toml import key_step
from lostmotion.mechanism.holding_torques import holding_torques
from lostmotion.mechanism.leg_copies import leg_copies
from lostmotion.parts.gearbox.kinds import turning_gearbox
from lostmotion.sizing.candidates import PartCandidate, Slot

if TYPE_CHECKING:
    from lostmotion.io.sizing_options import OptionTables
    from lostmotion.parts.joint import Joint, RevoluteJoint

CATALOGUE: Final = "catalogue"
# Catalogue rows rated below this share of the present holding torque are excluded: lighter links do
# not save as much.
_LEAST_RATING: Final = 0.5
_TORQUE_POSES: Final = 256


def gearbox_slot(options: OptionTables, joint: Joint, stated: Any) -> Slot | None:  # noqa: ANN401 - whatever a file holds
    """Return the gearboxes offered for a joint; None where there is a mistake.

    `stated` is a list of names, in which "catalogue" stands for all suitable rows, beside the
    others; or "catalogue" alone.
    """
    key = option_key("gearboxes", joint.name)
    if joint.type != "revolute":
        options.refuse(
            key,
            f"the joint '{joint.name}', which is not revolute",
            "a revolute joint",
            GEARBOX_EXAMPLE,
        )
        return None
    names = [CATALOGUE] if stated == CATALOGUE else options.names(key, stated, GEARBOX_EXAMPLE)
    named = [
        each
        for name in names
        if name != CATALOGUE and (each := _gearbox_candidate(options, joint, name, key)) is not None
    ]
    if named:
        _require_costs(options, [each for each in named if each.name != PRESENT])
    known = {each.name for each in named}
    suitable = (
        [_gearbox_candidate(options, joint, name, key) for name in _suitable(options, joint)]
        if CATALOGUE in names
        else []
    )
    others = [each for each in suitable if each is not None and each.name not in known]
    candidates = [
        *named,
        *(
            _with_known_costs(options, joint, others, key)
            if others or (CATALOGUE in names and not named)
            else []
        ),
    ]
    return _slot(options, joint, candidates) if candidates else None


def _gearbox_candidate(
    options: OptionTables, joint: RevoluteJoint, name: str, key: str
) -> PartCandidate | None:
    if name == PRESENT:
        return PartCandidate(PRESENT, None)
    ratio = _ratio_of(joint)
    try:
        rows, model, behind = find_rows(name, options.rows)
        if behind is not None or not any(
            ratio is not None and row.applies_to(ratio) for row in rows
        ):
            ratio = None
        row, ratio = find_gearbox(name, ratio, options.rows)
    except InputError as error:
        problem = error.problems[0]
        example = f'{key_step(joint.name)} = ["{problem.nearest or problem.example}"]'
        options.refuse(
            key, problem.found, f"{problem.expected}; or present", example, problem.nearest
        )
        return None
    if (
        ratio is None
        and joint.encoder is not None
        and joint.encoder.side == "motor"
        and joint.encoder.ratio is None
    ):
        expected = "the ratio behind the name, which divides the errors of the motor encoder"
        options.refuse(key, f"{shown(name)} without its ratio", expected, f'"{model}-121"')
        return None
    full_name = model if ratio is None else f"{model}-{ratio:g}"
    tree = row.with_stated({"model": full_name, **({} if ratio is None else {"ratio": ratio})})
    part = turning_gearbox(tree)
    cost = options.cost(full_name, name, model)
    in_file = any(row is own for own in options.in_file)
    if row.mass_source and cost.mass is None:
        options.notes.append(f"mass of {full_name}: {row.mass_source}")
    return PartCandidate(
        full_name,
        part,
        _first_known(cost.mass, part.mass),
        math.nan if cost.price is None else cost.price,
        {**tree, "ratio": ratio}
        if in_file and ratio is not None
        else tree
        if in_file
        else full_name,
        note=row.note(full_name, {}),
    )


def _suitable(options: OptionTables, joint: RevoluteJoint) -> list[str]:
    """Return the names of all rows that have the joint's ratio and are rated for at least half of
    its holding torque, or that of a copy of it.
    """
    _, torques = holding_torques(options.arm, sample_poses(options.arm, _TORQUE_POSES).q)
    copies = leg_copies(options.arm, "gearbox")[joint.name]
    torque = max(abs(each.worst) for each in torques if each.joint in copies)
    ratio = _ratio_of(joint)
    names = []
    for row in [*options.in_file, *options.own, *gearboxes()]:
        rated = row.figures.part.rated_torque
        if (
            rated is not None
            and rated >= _LEAST_RATING * torque
            and (ratio is None or row.applies_to(ratio))
        ):
            own = row.typical_ratio
            names.append(
                row.models[0] if ratio is not None or own is None else f"{row.models[0]}-{own:g}"
            )
    return list(dict.fromkeys(names))


def _with_known_costs(
    options: OptionTables, joint: Joint, candidates: list[PartCandidate], key: str
) -> list[PartCandidate]:
    known = [each for each in candidates if not _unknown(options, each)]
    if len(known) < len(candidates):
        names = listed([each.name for each in candidates if _unknown(options, each)])
        count = len(candidates) - len(known)
        options.notes.append(
            f"gearbox of {joint.name}: {count} rows of the catalogue excluded, because their "
            f"costs are not stated: {names}"
        )
    if not known:
        expected = "costs of suitable reducers in [sizing.costs], by name or by pattern"
        options.refuse(
            key, f"{len(candidates)} suitable reducers without costs", expected, COST_EXAMPLE
        )
    return known


def _unknown(options: OptionTables, candidate: PartCandidate) -> list[str]:
    """Return the quantities of a candidate that count in the objective and are unknown."""
    quantities = (
        ("mass", options.objective.per_kg, candidate.mass),
        ("price", options.objective.per_price, candidate.price),
    )
    return [name for name, weight, value in quantities if weight and math.isnan(value)]


def _require_costs(options: OptionTables, candidates: list[PartCandidate]) -> None:
    for quantity, example in (("mass", '"4.7 kg"'), ("price", "900")):
        unknown = [each.name for each in candidates if quantity in _unknown(options, each)]
        if unknown:
            table = f'[sizing.costs] with "{unknown[0]}" = {{ {quantity} = {example} }}'
            expected = f"the {quantity} of every candidate, which is to be minimised"
            options.refuse("sizing.costs", f"no {quantity} of {listed(unknown)}", expected, table)


def _slot(options: OptionTables, joint: Joint, candidates: list[PartCandidate]) -> Slot | None:
    """Return the slot with the mass and price of the present gearbox; None where there is a
    mistake.

    A selected gearbox replaces the present one, so the joint's mass changes by the difference.
    Where the mass of the present one is unknown, the joint keeps its mass; a candidate of unknown
    mass counts as zero. Both are noted.
    """
    gearbox = getattr(joint, "gearbox", None)
    now = options.present.get(joint.name) or (
        options.cost(gearbox.model) if gearbox is not None and gearbox.model else options.cost()
    )
    name = (gearbox.model or f"{gearbox.kind} gearbox") if gearbox is not None else "none"
    others = [each for each in candidates if each.name != PRESENT]
    unknown = [each.name for each in others if math.isnan(each.mass)]
    mass = _first_known(now.mass, None if gearbox is None else gearbox.mass)
    if math.isnan(mass) and not joint.total_mass and len(others) == len(candidates):
        mass = 0.0  # a joint without mass contains no gearbox to be removed
    has_masses = len(unknown) < len(others)
    key, example = option_key(PRESENT, joint.name), present_example(joint.name)
    unchanged = "the joint keeps its mass for every candidate"
    if has_masses and math.isnan(mass):
        if options.objective.per_kg or any(
            cost.mass is not None for cost in options.costs.values()
        ):
            found = (
                f"masses of gearboxes for {joint.name}, but not of the present one, {name}, which "
                "they replace"
            )
            expected = (
                f"the part of the joint's {joint.total_mass:g} kg that is its present gearbox; 0 "
                "kg where it is not included"
            )
            options.refuse(key, found, expected, example)
            return None
        options.notes.append(
            f"gearbox of {joint.name}: mass of the present one, {name}, not stated: {unchanged}"
        )
        has_masses = False
    elif unknown:
        counted = "counted as zero" if has_masses else unchanged
        options.notes.append(
            f"gearbox of {joint.name}: mass of {listed(unknown)} not stated: {counted}"
        )
    if has_masses and mass > joint.total_mass:
        found = f"a present gearbox of {mass:g} kg in a joint of {joint.total_mass:g} kg"
        options.refuse(key, found, "no more than the joint's own mass", example)
        return None
    price = math.nan if now.price is None else now.price
    if options.objective.per_price and len(others) < len(candidates) and math.isnan(price):
        options.refuse(
            key,
            "no price of the present gearbox, which is among the candidates",
            "its price",
            example,
        )
        return None
    present_mass = mass if has_masses else 0.0
    priced = []
    for each in candidates:
        own = 0.0 if math.isnan(each.mass) or not has_masses else each.mass
        weight, cost = (present_mass, price) if each.part is None else (own, each.price)
        priced.append(
            replace(
                each,
                mass=weight,
                price=cost if options.objective.per_price or not math.isnan(cost) else 0.0,
            )
        )
    return Slot(
        joint.name,
        "gearbox",
        tuple(priced),
        PartCandidate(name, None, present_mass, price),
        mass_in_joint=present_mass,
        has_masses=has_masses,
    )


def _first_known(*masses: float | None) -> float:
    """Return the first mass that is stated; NaN where none is."""
    return next((mass for mass in masses if mass is not None), math.nan)


def _ratio_of(joint: RevoluteJoint) -> float | None:
    """Return the ratio of the joint's present gearbox; None where it is not stated."""
    gearbox = joint.gearbox
    return abs(float(gearbox.ratio)) if gearbox is not None and gearbox.states_ratio else None


def bearing_slot(options: OptionTables, joint: Joint, stated: Any) -> Slot | None:  # noqa: ANN401 - whatever a file holds
    """Return the clearances offered for the bearing of a joint; None where there is a mistake."""
    key = option_key("bearings", joint.name)
    bearing = getattr(joint, "bearing", None)
    if bearing is None or "clearance" not in type(bearing).model_fields:
        found = f"the joint '{joint.name}', which has no bearing with a clearance"
        suitable = [
            each.name
            for each in options.arm.moving
            if each.bearing is not None and "clearance" in type(each.bearing).model_fields
        ]
        options.refuse(
            key, found, f"a joint with one: {listed(suitable) or 'none has'}", BEARING_EXAMPLE
        )
        return None
    candidates = [
        each
        for name in options.names(key, stated, BEARING_EXAMPLE)
        if (each := _bearing_candidate(options, bearing, name, key)) is not None
    ]
    if not candidates:
        return None
    if options.objective.per_price and all(math.isnan(each.price) for each in candidates):
        options.notes.append(
            f"bearing of {joint.name}: no prices of clearances are stated, counted as zero"
        )
    now = bearing.clearance
    name = f"{now.nominal * 1e6:.4g} µm" + (
        f" ± {now.tolerance * 1e6:.3g} µm" if now.tolerance else ""
    )
    priced = tuple(
        replace(each, price=0.0) if math.isnan(each.price) else each for each in candidates
    )
    return Slot(joint.name, "bearing", priced, PartCandidate(name, None))


def _bearing_candidate(
    options: OptionTables,
    bearing: Any,  # noqa: ANN401 - any kind of bearing
    name: str,
    key: str,
) -> PartCandidate | None:
    """Return the bearing with a clearance, its price NaN where none is stated; None where there is
    a mistake.
    """
    cost = options.cost(name)
    price = math.nan if cost.price is None else cost.price
    if name == PRESENT:
        return PartCandidate(PRESENT, None, price=price)
    clearance: Any = name
    if name[:1].upper() == "C":
        table = TABLES.get(bearing.kind)
        if table is None:
            expected = (
                "a length, because the standard has no groups for a bearing of kind "
                f"'{bearing.kind}', or its bore is unknown"
            )
            options.refuse(key, shown(name), expected, '"30 µm ± 10 µm"')
            return None
        try:
            clearance = clearance_of_group(table, bearing.bore, name)
        except InputError as error:
            problem = error.problems[0]
            options.refuse(
                key,
                problem.found,
                problem.expected,
                f'"{problem.nearest or "CN"}"',
                problem.nearest,
            )
            return None
    fields = {field: getattr(bearing, field) for field in bearing.model_fields_set} | {
        "clearance": clearance
    }
    try:
        part = type(bearing).model_validate(fields)
    except ValidationError as error:
        context = error.errors()[0].get("ctx", {})
        expected = str(context.get("expected", "a clearance: a group, or a length"))
        options.refuse(key, str(context.get("why", shown(name))), expected, '"30 µm ± 10 µm"')
        return None
    if part.model_dump() == bearing.model_dump():
        return PartCandidate(name, None, price=price)
    return PartCandidate(name, part, price=price, file_value=name)


def selection_slots(options: OptionTables) -> list[Slot]:
    """Return the gearboxes and bearings to select, in the order of the arm's joints; mistakes go
    into `options.mistakes`.
    """
    joints = {joint.name: joint for joint in options.arm.joints}
    options.read_costs()
    slots: dict[tuple[str, str], Slot] = {}
    for table, kind, slot_of, example in (
        ("gearboxes", "gearbox", gearbox_slot, GEARBOX_EXAMPLE),
        ("bearings", "bearing", bearing_slot, BEARING_EXAMPLE),
    ):
        for name, stated in options.table(table, example).items():
            if options.has_joint(table, name, example) and (
                slot := slot_of(options, joints[name], stated)
            ):
                slots[name, kind] = slot
    return [
        slots[name, kind]
        for name in joints
        for kind in ("gearbox", "bearing")
        if (name, kind) in slots
    ]
