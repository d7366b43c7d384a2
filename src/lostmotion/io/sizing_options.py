"""Tables with which a sizing file offers gearboxes and clearances for a target on the tool: checks
of names and lists, the costs of parts, and what is minimised.

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
from dataclasses import dataclass, field
from fnmatch import fnmatchcase
from functools import partial
from typing import TYPE_CHECKING, Annotated, Any, Final

from pydantic import ValidationError

from lostmotion.catalogue.gearboxes import by_model
from lostmotion.errors import Problem, shown
from lostmotion.io.draft import plain
from lostmotion.io.limits import listed, nearest
from lostmotion.io.toml import key_step
from lostmotion.io.validation_errors import problems
from lostmotion.parts.error_source import Mass, Part
from lostmotion.sizing.candidates import Objective
from lostmotion.units import Quantity

if TYPE_CHECKING:
    from collections.abc import Mapping, Sequence

    from lostmotion.catalogue.gearbox_row import GearboxRow
    from lostmotion.io.validation_errors import Path as KeyPath
    from lostmotion.mechanism.arm import Arm

PRESENT: Final = "present"
GEARBOX_EXAMPLE: Final = (
    '[sizing.gearboxes] with A = ["present", "RV-20E-121", "RV-40E-121"], A = "catalogue", or A = '
    '["present", "catalogue"]'
)
BEARING_EXAMPLE: Final = (
    '[sizing.bearings] with A = ["C2", "CN"], or A = ["10 µm ± 5 µm", "30 µm ± 10 µm"]'
)
COST_EXAMPLE: Final = '[sizing.costs] with "RV-20E*" = { mass = "4.7 kg", price = 900 }'
_PRESENT_EXAMPLE: Final = '[sizing.present] with {joint} = {{ mass = "4 kg", price = 800 }}'
_MOST: Final = 100


class PartCost(Part):
    """Mass and price of a part; None where unknown."""

    mass: Mass | None = None
    price: Annotated[float, Quantity("", "900", low=0)] | None = None


@dataclass
class OptionTables:
    """The option tables of one sizing file.

    own, in_file  reducers described in the arm file and in this file
    mistakes      of the file; notes for the report
    rows          reducers of both files by model; costs by name or pattern; present costs by joint
                  (all set by `read_costs`)
    """

    file: str
    tables: dict[str, Any]
    arm: Arm
    objective: Objective
    own: Sequence[GearboxRow] = ()
    in_file: Sequence[GearboxRow] = ()
    mistakes: list[Problem] = field(default_factory=list)
    notes: list[str] = field(default_factory=list)
    rows: Mapping[str, Sequence[GearboxRow]] = field(default_factory=dict)
    costs: dict[str, PartCost] = field(default_factory=dict)
    present: dict[str, PartCost] = field(default_factory=dict)

    def read_costs(self) -> None:
        """Read costs of parts and of present gearboxes."""
        self.rows = by_model([*self.in_file, *self.own])
        self.costs = self._costs("costs", COST_EXAMPLE)
        example = present_example(self.arm.joints[0].name)
        self.present = self._costs(PRESENT, example)
        for name in self.present:
            self.has_joint(PRESENT, name, example)

    def refuse(self, key: str, found: str, expected: str, example: str, near: str = "") -> None:
        """Note a mistake."""
        self.mistakes.append(Problem(self.file, key, found, expected, example, near))

    def table(self, name: str, example: str) -> dict[str, Any]:
        """Return a table of options, empty where it is missing or wrong."""
        stated = self.tables.get(name, {})
        if isinstance(stated, dict) and len(stated) <= _MOST:
            return stated
        found = shown(stated) if not isinstance(stated, dict) else f"{len(stated)} entries"
        self.refuse(f"sizing.{name}", found, f"a table, at most {_MOST}", example)
        return {}

    def has_joint(self, table: str, name: str, example: str) -> bool:
        """Return whether the arm has this joint, and note a mistake where not."""
        joints = [joint.name for joint in self.arm.joints]
        if name in joints:
            return True
        self.refuse(
            option_key(table, name),
            "no such joint",
            f"one of {listed(joints)}",
            example,
            nearest(name, joints),
        )
        return False

    def names(self, key: str, stated: Any, example: str) -> list[str]:  # noqa: ANN401 - whatever a file holds
        """Return a list of names without repetitions, empty where it is wrong."""
        if (
            isinstance(stated, list)
            and 0 < len(stated) <= _MOST
            and all(isinstance(each, str) for each in stated)
        ):
            return list(dict.fromkeys(stated))
        self.refuse(key, shown(stated), f"a list of 1 to {_MOST} names", example)
        return []

    def cost(self, *names: str) -> PartCost:
        """Return the cost stated for the first of these names, or for a pattern that matches
        one.
        """
        for name in names:
            if name in self.costs:
                return self.costs[name]
        return next(
            (
                cost
                for pattern, cost in self.costs.items()
                for name in names
                if fnmatchcase(name, pattern)
            ),
            PartCost(),
        )

    def _costs(self, table: str, example: str) -> dict[str, PartCost]:
        out = {}
        for name, stated in self.table(table, example).items():
            key = option_key(table, name)
            if not isinstance(stated, dict):
                self.refuse(key, shown(stated), "a table with mass, price or both", example)
                continue
            text = {
                what: str(value) if what == "price" and type(value) in {int, float} else value
                for what, value in stated.items()
            }
            try:
                out[name] = PartCost.model_validate(text, context={"text": True})
            except ValidationError as error:
                self.mistakes += problems(error, PartCost, self.file, partial(_within, key))
        return out


def present_example(joint: str) -> str:
    """Return an example of the table of present gearboxes for a joint."""
    return _PRESENT_EXAMPLE.format(joint=key_step(joint))


def option_key(table: str, name: str) -> str:
    """Return the key of an entry of an option table."""
    return f"sizing.{table}.{key_step(plain(name))}"


def _within(key: str, where: KeyPath) -> str:
    return ".".join([key, *map(str, where)])


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
