"""Gearboxes that a sizing file offers for a joint, with their masses and prices."""

from __future__ import annotations

import math
from dataclasses import replace
from typing import TYPE_CHECKING, Any, Final

from pydantic import TypeAdapter

from lostmotion.analyses.sizing.candidates import Candidate, Slot
from lostmotion.analyses.sizing.option_tables import (
    COST_EXAMPLE,
    GEARBOX_EXAMPLE,
    PRESENT,
    option_key,
    present_example,
)
from lostmotion.catalogue.gearboxes import find_gearbox, find_rows, gearboxes
from lostmotion.error_model.poses import sample_poses
from lostmotion.errors import InputError, shown
from lostmotion.io.limits import listed
from lostmotion.io.toml import key_step
from lostmotion.mechanism.holding_torques import holding_torques
from lostmotion.parts.gearbox.kinds import TurningGearbox

if TYPE_CHECKING:
    from lostmotion.analyses.sizing.option_tables import OptionTables
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
        if name != CATALOGUE and (each := _candidate(options, joint, name, key)) is not None
    ]
    if named:
        _require_costs(options, [each for each in named if each.name != PRESENT])
    known = {each.name for each in named}
    suitable = (
        [_candidate(options, joint, name, key) for name in _suitable(options, joint)]
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


def _candidate(
    options: OptionTables, joint: RevoluteJoint, name: str, key: str
) -> Candidate | None:
    if name == PRESENT:
        return Candidate(PRESENT, None)
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
    part = TypeAdapter(TurningGearbox).validate_python(tree, context={"text": True})
    cost = options.cost(full_name, name, model)
    in_file = any(row is own for own in options.in_file)
    if row.mass_source and cost.mass is None:
        options.notes.append(f"mass of {full_name}: {row.mass_source}")
    return Candidate(
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
    its holding torque.
    """
    _, torques = holding_torques(options.arm, sample_poses(options.arm, _TORQUE_POSES).q)
    torque = next(abs(each.worst) for each in torques if each.joint == joint.name)
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
    options: OptionTables, joint: Joint, candidates: list[Candidate], key: str
) -> list[Candidate]:
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


def _unknown(options: OptionTables, candidate: Candidate) -> list[str]:
    """Return the quantities of a candidate that count in the objective and are unknown."""
    quantities = (
        ("mass", options.objective.per_kg, candidate.mass),
        ("price", options.objective.per_price, candidate.price),
    )
    return [name for name, weight, value in quantities if weight and math.isnan(value)]


def _require_costs(options: OptionTables, candidates: list[Candidate]) -> None:
    for quantity, example in (("mass", '"4.7 kg"'), ("price", "900")):
        unknown = [each.name for each in candidates if quantity in _unknown(options, each)]
        if unknown:
            table = f'[sizing.costs] with "{unknown[0]}" = {{ {quantity} = {example} }}'
            expected = f"the {quantity} of every candidate, which is to be minimised"
            options.refuse("sizing.costs", f"no {quantity} of {listed(unknown)}", expected, table)


def _slot(options: OptionTables, joint: Joint, candidates: list[Candidate]) -> Slot | None:
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
        Candidate(name, None, present_mass, price),
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
