"""Gearboxes and clearances that a sizing file offers for a target on the tool, with their masses
and prices.

    [sizing]
    target = "0.5 mm"                        # the 95 % error over the workspace
    minimise = "price + 20 * mass"           # or "mass" (the default), or "price"; masses in kg
    price_per_kg = 12                        # of links

    [sizing.gearboxes]                       # by the name of the joint
    A = ["present", "RV-20E", "RV-40E-121"]  # the present one, rows of the catalogue, of the arm
                                             file, or of this file ([[reducers]])
    B = "catalogue"                          # all suitable rows; ["present", "catalogue"] offers
                                             the present one as well

    [sizing.bearings]
    A = ["C2", "CN", "C3"]                   # groups of ISO 5753-1, or lengths: "10 µm ± 10 µm"

    [sizing.costs]                           # by name, model or pattern: prices, and masses that
                                             override the catalogue's
    "RV-20E" = { mass = "4.7 kg", price = 900 }
    "RV-*" = { mass = "9 kg", price = 1400 }
    C2 = { price = 60 }

    [sizing.present]                         # of a joint's present gearbox: its part of the joint's
                                             mass
    A = { mass = "4 kg", price = 800 }

A name without its ratio takes that of the present gearbox, where the manufacturer's figures are
valid for it.
"""

from __future__ import annotations

import math
import re
from typing import TYPE_CHECKING, Final

from lostmotion.analyses.sizing.bearing_options import bearing_slot
from lostmotion.analyses.sizing.candidates import Objective
from lostmotion.analyses.sizing.gearbox_options import gearbox_slot
from lostmotion.analyses.sizing.option_tables import BEARING_EXAMPLE, GEARBOX_EXAMPLE

if TYPE_CHECKING:
    from lostmotion.analyses.sizing.candidates import Slot
    from lostmotion.analyses.sizing.option_tables import OptionTables

OPTION_TABLES: Final = ("gearboxes", "bearings", "costs", "present")
OBJECTIVE_EXAMPLE: Final = 'minimise = "price + 20 * mass"'
_TERM: Final = re.compile(
    r"\s*(?:(?P<factor>[0-9]+(?:\.[0-9]*)?(?:e[+-]?[0-9]+)?)\s*\*\s*)?(?P<quantity>mass|price)\s*"
)


def parse_objective(text: str) -> Objective | None:
    """Return the objective that a sum states ("mass", "price", "price + 20 * mass"); None where it
    cannot be read.
    """
    factors: dict[str, float] = {}
    for part in text.split("+"):
        term = _TERM.fullmatch(part)
        if term is None or term["quantity"] in factors:
            return None
        factors[term["quantity"]] = float(term["factor"] or 1)
    objective = Objective(factors.get("mass", 0.0), factors.get("price", 0.0))
    return objective if 0 < objective.per_kg + objective.per_price < math.inf else None


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
