"""Bearing clearances that a sizing file offers for a joint."""

from __future__ import annotations

import math
from dataclasses import replace
from typing import TYPE_CHECKING, Any

from pydantic import ValidationError

from lostmotion.analyses.sizing.candidates import Candidate, Slot
from lostmotion.analyses.sizing.option_tables import BEARING_EXAMPLE, PRESENT, option_key
from lostmotion.catalogue.clearances import clearance_of_group
from lostmotion.errors import InputError, shown
from lostmotion.io.clearances import TABLES
from lostmotion.io.limits import listed

if TYPE_CHECKING:
    from lostmotion.analyses.sizing.option_tables import OptionTables
    from lostmotion.parts.joint import Joint


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
        if (each := _candidate(options, bearing, name, key)) is not None
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
    return Slot(joint.name, "bearing", priced, Candidate(name, None))


def _candidate(options: OptionTables, bearing: Any, name: str, key: str) -> Candidate | None:  # noqa: ANN401 - any kind of bearing
    """Return the bearing with a clearance, its price NaN where none is stated; None where there is
    a mistake.
    """
    cost = options.cost(name)
    price = math.nan if cost.price is None else cost.price
    if name == PRESENT:
        return Candidate(PRESENT, None, price=price)
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
        return Candidate(name, None, price=price)
    return Candidate(name, part, price=price, file_value=name)
