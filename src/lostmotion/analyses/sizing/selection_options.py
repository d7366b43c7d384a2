"""What gearboxes and clearances a sizing file offers for a target on the tool, and what they weigh and cost.

    [sizing]
    target = "0.5 mm"                        # the 95 % error over the workspace
    minimise = "price + 20 * mass"           # or "mass" (as long as nothing is said), or "price"; masses in kg
    price_per_kg = 12                        # of links

    [sizing.gearboxes]                       # by the name of the joint
    A = ["present", "RV-20E", "RV-40E-121"]  # the one there is, rows of the catalogue, of the arm file, or of this file ([[reducers]])
    B = "catalogue"                          # all rows that fit

    [sizing.bearings]
    A = ["C2", "CN", "C3"]                   # groups of ISO 5753-1, or lengths: "10 µm ± 10 µm"

    [sizing.costs]                           # by name, by model, or by pattern: prices, and masses that go before the catalogue's
    "RV-20E" = { mass = "4.7 kg", price = 900 }
    "RV-*" = { mass = "9 kg", price = 1400 }
    C2 = { price = 60 }

    [sizing.present]                         # of the gearbox a joint has now: what it weighs within the joint's mass
    A = { mass = "4 kg", price = 800 }

A name without its ratio takes that of the present gearbox, where the maker's figures hold for it.
"""

from __future__ import annotations

import math
import re
from dataclasses import dataclass, field, replace
from fnmatch import fnmatchcase
from functools import partial
from typing import TYPE_CHECKING, Annotated, Any, Final

from pydantic import TypeAdapter, ValidationError

from lostmotion.analyses.sizing.candidates import Candidate, Slot, Worth
from lostmotion.catalogue.clearances import clearance_of_group
from lostmotion.catalogue.gearboxes import by_model, find_gearbox, find_rows, gearboxes
from lostmotion.error_model.poses import sample_poses
from lostmotion.errors import InputError, Problem, shown
from lostmotion.io.clearances import TABLES
from lostmotion.io.draft import plain
from lostmotion.io.limits import listed, nearest
from lostmotion.io.toml import key_step
from lostmotion.io.validation_errors import problems
from lostmotion.mechanism.holding_torques import holding_torques
from lostmotion.parts.error_source import Mass, Part
from lostmotion.parts.gearbox.catalogue import CatalogueGearbox
from lostmotion.parts.gearbox.kinds import TurningGearbox
from lostmotion.parts.joint import RevoluteJoint
from lostmotion.units import Quantity

if TYPE_CHECKING:
    from collections.abc import Sequence

    from lostmotion.catalogue.gearboxes import GearboxRow
    from lostmotion.io.validation_errors import Path as KeyPath
    from lostmotion.mechanism.arm import Arm
    from lostmotion.parts.joint import Joint

TABLES_OFFERED: Final = ("gearboxes", "bearings", "costs", "present")
PRESENT: Final = "present"
CATALOGUE: Final = "catalogue"
WORTH_EXAMPLE: Final = 'minimise = "price + 20 * mass"'
_MOST: Final = 100
_GEARBOX_EXAMPLE: Final = '[sizing.gearboxes] with A = ["present", "RV-20E-121", "RV-40E-121"], or A = "catalogue"'
_BEARING_EXAMPLE: Final = '[sizing.bearings] with A = ["C2", "CN"], or A = ["10 µm ± 5 µm", "30 µm ± 10 µm"]'
_COST_EXAMPLE: Final = '[sizing.costs] with "RV-20E*" = { mass = "4.7 kg", price = 900 }'
_PRESENT_EXAMPLE: Final = '[sizing.present] with {joint} = {{ mass = "4 kg", price = 800 }}'
_TERM: Final = re.compile(r"\s*(?:(?P<factor>[0-9]+(?:\.[0-9]*)?(?:e[+-]?[0-9]+)?)\s*\*\s*)?(?P<what>mass|price)\s*")
# Of the whole catalogue, reducers rated for less than this share of what the joint holds as stated are not looked at: no links are so much lighter.
_LIGHTER: Final = 0.5
_TORQUE_POSES: Final = 256


class Cost(Part):
    """What a part weighs and costs; what is left out is not known."""

    mass: Mass | None = None
    price: Annotated[float, Quantity("", "900", low=0)] | None = None


def worth_of(text: str) -> Worth | None:
    """What does this sum ask to be small? "mass", "price", "price + 20 * mass"; None where it cannot be read."""
    factors: dict[str, float] = {}
    for part in text.split("+"):
        term = _TERM.fullmatch(part)
        if term is None or term["what"] in factors:
            return None
        factors[term["what"]] = float(term["factor"] or 1)
    worth = Worth(factors.get("mass", 0.0), factors.get("price", 0.0))
    return worth if 0 < worth.mass + worth.price < math.inf else None


@dataclass
class Offers:
    """The tables of one sizing file; `slots` makes of them what may be chosen, `mistakes` holds what is wrong, `notes` what should be known."""

    file: str
    tables: dict[str, Any]
    arm: Arm
    worth: Worth
    own: Sequence[GearboxRow] = ()
    in_file: Sequence[GearboxRow] = ()
    mistakes: list[Problem] = field(default_factory=list)
    notes: list[str] = field(default_factory=list)

    def slots(self) -> list[Slot]:
        """Which gearboxes and bearings may be chosen, in the order of the arm's joints?"""
        self._rows = by_model([*self.in_file, *self.own])
        self._costs = self._read_costs("costs", _COST_EXAMPLE)
        joints = {joint.name: joint for joint in self.arm.joints}
        self._present = self._read_costs(PRESENT, _PRESENT_EXAMPLE.format(joint=key_step(next(iter(joints)))))
        for name in self._present:
            self._known_joint(PRESENT, name, joints)
        offered: dict[tuple[str, str], Slot] = {}
        for name, stated in self._table("gearboxes", _GEARBOX_EXAMPLE).items():
            if self._known_joint("gearboxes", name, joints) and (slot := self._gearbox_slot(joints[name], stated)):
                offered[name, "gearbox"] = slot
        for name, stated in self._table("bearings", _BEARING_EXAMPLE).items():
            if self._known_joint("bearings", name, joints) and (slot := self._bearing_slot(joints[name], stated)):
                offered[name, "bearing"] = slot
        return [offered[name, what] for name in joints for what in ("gearbox", "bearing") if (name, what) in offered]

    # ---- reading

    def _refuse(self, key: str, found: str, expected: str, example: str, near: str = "") -> None:
        self.mistakes.append(Problem(self.file, key, found, expected, example, near))

    def _table(self, name: str, example: str) -> dict[str, Any]:
        stated = self.tables.get(name, {})
        if isinstance(stated, dict) and len(stated) <= _MOST:
            return stated
        found = shown(stated) if not isinstance(stated, dict) else f"{len(stated)} entries"
        self._refuse(f"sizing.{name}", found, f"a table, at most {_MOST}", example)
        return {}

    def _read_costs(self, table: str, example: str) -> dict[str, Cost]:
        out = {}
        for name, stated in self._table(table, example).items():
            key = _key(table, name)
            if not isinstance(stated, dict):
                self._refuse(key, shown(stated), "a table with mass, price or both", example)
                continue
            said = {what: str(value) if what == "price" and type(value) in {int, float} else value for what, value in stated.items()}
            try:
                out[name] = Cost.model_validate(said, context={"text": True})
            except ValidationError as error:
                self.mistakes += problems(error, Cost, self.file, partial(_within, key))
        return out

    def _known_joint(self, table: str, name: str, joints: dict[str, Joint]) -> bool:
        if name in joints:
            return True
        example = {"gearboxes": _GEARBOX_EXAMPLE, "bearings": _BEARING_EXAMPLE}.get(
            table, _PRESENT_EXAMPLE.format(joint=key_step(next(iter(joints))))
        )
        self._refuse(_key(table, name), "no such joint", f"one of {listed(list(joints))}", example, nearest(name, joints))
        return False

    def _names(self, key: str, stated: Any, example: str) -> list[str]:  # noqa: ANN401 - whatever a file holds
        if isinstance(stated, list) and 0 < len(stated) <= _MOST and all(isinstance(each, str) for each in stated):
            return list(dict.fromkeys(stated))
        self._refuse(key, shown(stated), f"a list of 1 to {_MOST} names", example)
        return []

    def _cost(self, *names: str) -> Cost:
        """Give what is said of a part by the first of these names, or by a pattern for it."""
        for name in names:
            if name in self._costs:
                return self._costs[name]
        return next((cost for pattern, cost in self._costs.items() for name in names if fnmatchcase(name, pattern)), Cost())

    # ---- gearboxes

    def _gearbox_slot(self, joint: Joint, stated: Any) -> Slot | None:  # noqa: ANN401 - whatever a file holds
        key = _key("gearboxes", joint.name)
        if not isinstance(joint, RevoluteJoint):
            self._refuse(key, f"the joint '{joint.name}', which does not turn", "a turning joint: reducers of the catalogue turn", _GEARBOX_EXAMPLE)
            return None
        whole = stated == CATALOGUE
        names = self._fitting(joint) if whole else self._names(key, stated, _GEARBOX_EXAMPLE)
        made = [each for name in names if (each := self._gearbox(joint, name, key)) is not None]
        if whole:
            made = self._with_known_costs(joint, made, key)
        elif made:
            self._ask_for_costs([each for each in made if each.name != PRESENT])
        if not made:
            return None
        return self._weighed(joint, made)

    def _gearbox(self, joint: RevoluteJoint, name: str, key: str) -> Candidate | None:
        if name == PRESENT:
            return Candidate(PRESENT, None)
        ratio = _ratio_of(joint)
        try:
            rows, model, behind = find_rows(name, self._rows)
            if behind is not None or not any(ratio is not None and row.applies_to(ratio) for row in rows):
                ratio = None
            row, ratio = find_gearbox(name, ratio, self._rows)
        except InputError as error:
            problem = error.problems[0]
            example = f'{key_step(joint.name)} = ["{problem.nearest or problem.example}"]'
            self._refuse(key, problem.found, f"{problem.expected}; or present", example, problem.nearest)
            return None
        if ratio is None and joint.encoder is not None and joint.encoder.side == "motor" and joint.encoder.ratio is None:
            expected = "the ratio behind the name: the encoder's errors are divided by it"
            self._refuse(key, f"{shown(name)} without its ratio", expected, f'"{model}-121"')
            return None
        said = model if ratio is None else f"{model}-{ratio:g}"
        tree = row.with_stated({"model": said, **({} if ratio is None else {"ratio": ratio})})
        part = TypeAdapter(TurningGearbox).validate_python(tree, context={"text": True})
        cost = self._cost(said, name, model)
        in_file = any(row is mine for mine in self.in_file)
        if row.mass_source and cost.mass is None:
            self.notes.append(f"mass of {said}: {row.mass_source}")
        return Candidate(
            said,
            part,
            _known(cost.mass, part.mass),
            math.nan if cost.price is None else cost.price,
            {**tree, "ratio": ratio} if in_file and ratio is not None else tree if in_file else said,
            note=row.note(said, {}),
        )

    def _fitting(self, joint: RevoluteJoint) -> list[str]:
        """Give the present gearbox, where there is one, and the names of all rows that fit the joint's ratio and are rated for half of its load."""
        _, held = holding_torques(self.arm, sample_poses(self.arm, _TORQUE_POSES).q)
        torque = next(abs(each.worst) for each in held if each.joint == joint.name)
        ratio = _ratio_of(joint)
        names = []
        for row in [*self.in_file, *self.own, *gearboxes()]:
            rated = row.figures.part.rated_torque
            if rated is not None and rated >= _LIGHTER * torque and (ratio is None or row.applies_to(ratio)):
                own = row.ratio or (None if row.ratio_above is None else max(100.0, 2 * row.ratio_above))
                names.append(row.models[0] if ratio is not None or own is None else f"{row.models[0]}-{own:g}")
        return list(dict.fromkeys(names))

    def _with_known_costs(self, joint: Joint, made: list[Candidate], key: str) -> list[Candidate]:
        kept = [each for each in made if not self._unknown(each)]
        if len(kept) < len(made):
            left = listed([each.name for each in made if self._unknown(each)])
            count = len(made) - len(kept)
            self.notes.append(f"gearbox of {joint.name}: {count} of the catalogue were left out, for no cost of them is stated: {left}")
        if not kept:
            expected = "a reducer of the catalogue that fits, with its costs; [sizing.costs] says them, by name or by pattern"
            self._refuse(key, f"{len(made)} reducers that fit, and no costs of them", expected, _COST_EXAMPLE)
        return kept

    def _unknown(self, candidate: Candidate) -> list[str]:
        """Name what is not known of a candidate and counts."""
        asked = (("mass", self.worth.mass, candidate.mass), ("price", self.worth.price, candidate.price))
        return [name for name, counts, value in asked if counts and math.isnan(value)]

    def _ask_for_costs(self, made: list[Candidate]) -> None:
        for what in ("mass", "price"):
            silent = [each.name for each in made if what in self._unknown(each)]
            if silent:
                amount = '"4.7 kg"' if what == "mass" else "900"
                example = f'[sizing.costs] with "{silent[0]}" = {{ {what} = {amount} }}'
                self._refuse("sizing.costs", f"no {what} of {listed(silent)}", f"the {what} of every candidate, for it is to be small", example)

    def _weighed(self, joint: Joint, made: list[Candidate]) -> Slot | None:
        """Put what the present gearbox weighs and costs beside the candidates.

        A gearbox chosen takes the present one's place in the mass of the joint, which so changes by the difference of the two masses. Where the
        present one's is not known, the joint weighs what it does now; a candidate of unknown mass counts as none. Both are noted.
        """
        gearbox = getattr(joint, "gearbox", None)
        now = self._present.get(joint.name) or (self._cost(gearbox.model) if gearbox is not None and gearbox.model else Cost())
        name = (gearbox.model or f"{gearbox.kind} gearbox") if gearbox is not None else "none"
        others = [each for each in made if each.name != PRESENT]
        silent = [each.name for each in others if math.isnan(each.mass)]
        mass = _known(now.mass, None if gearbox is None else gearbox.mass)
        if math.isnan(mass) and not joint.total_mass and len(others) == len(made):
            mass = 0.0  # a joint without any mass holds no gearbox that could be taken out of it
        weighs = len(silent) < len(others)
        example = _PRESENT_EXAMPLE.format(joint=key_step(joint.name))
        if weighs and math.isnan(mass):
            if self.worth.mass or any(cost.mass is not None for cost in self._costs.values()):
                found = f"the mass of gearboxes of {joint.name}, but not of the present one, {name}, which they replace"
                expected = f"how much of the joint's mass of {joint.total_mass:g} kg is its present gearbox; 0 kg where it is not in it"
                self._refuse(_key(PRESENT, joint.name), found, expected, example)
                return None
            self.notes.append(
                f"gearbox of {joint.name}: mass of the present one, {name}, not stated: the joint weighs what it does now, whichever is chosen"
            )
            weighs = False
        elif silent and not weighs:
            self.notes.append(f"gearbox of {joint.name}: mass of {listed(silent)} not stated: the joint weighs what it does now, whichever is chosen")
        elif silent:
            self.notes.append(f"gearbox of {joint.name}: mass of {listed(silent)} not stated: counted as none")
        if weighs and mass > joint.total_mass:
            found = f"a present gearbox of {mass:g} kg in a joint of {joint.total_mass:g} kg"
            self._refuse(_key(PRESENT, joint.name), found, "no more than the joint's own mass", example)
            return None
        price = math.nan if now.price is None else now.price
        if self.worth.price and len(others) < len(made) and math.isnan(price):
            self._refuse(_key(PRESENT, joint.name), "no price of the present gearbox, which is among the candidates", "its price", example)
            return None
        kept = mass if weighs else 0.0
        candidates = []
        for each in made:
            weight = 0.0 if math.isnan(each.mass) else each.mass
            own, cost = (kept, price) if each.part is None else (weight if weighs else 0.0, each.price)
            candidates.append(replace(each, mass=own, price=cost if self.worth.price or not math.isnan(cost) else 0.0))
        return Slot(joint.name, "gearbox", tuple(candidates), Candidate(name, None, kept, price), in_joint=kept, weighs=weighs)

    # ---- bearings

    def _bearing_slot(self, joint: Joint, stated: Any) -> Slot | None:  # noqa: ANN401 - whatever a file holds
        key = _key("bearings", joint.name)
        bearing = getattr(joint, "bearing", None)
        if bearing is None or "clearance" not in type(bearing).model_fields:
            found = f"the joint '{joint.name}', which has no bearing with a clearance"
            having = [each.name for each in self.arm.moving if each.bearing is not None and "clearance" in type(each.bearing).model_fields]
            self._refuse(key, found, f"a joint with one: {listed(having) or 'none has'}", _BEARING_EXAMPLE)
            return None
        made = [each for name in self._names(key, stated, _BEARING_EXAMPLE) if (each := self._bearing(bearing, name, key)) is not None]
        if self.worth.price and made and all(math.isnan(each[1]) for each in made):
            self.notes.append(f"bearing of {joint.name}: no prices of clearances are stated, taken as none")
        if not made:
            return None
        now = bearing.clearance
        name = f"{now.nominal * 1e6:.4g} µm" + (f" ± {now.tolerance * 1e6:.3g} µm" if now.tolerance else "")
        return Slot(joint.name, "bearing", tuple(_priced(each, price) for each, price in made), Candidate(name, None))

    def _bearing(self, bearing: Any, name: str, key: str) -> tuple[Candidate, float] | None:  # noqa: ANN401 - any kind of bearing
        cost = self._cost(name)
        price = math.nan if cost.price is None else cost.price
        if name == PRESENT:
            return Candidate(PRESENT, None), price
        clearance: Any = name
        if name[:1].upper() == "C":
            table = TABLES.get(bearing.kind)
            if table is None:
                expected = f"a length: of a bearing of kind '{bearing.kind}' no bore is known, or the standard has no groups for it"
                self._refuse(key, shown(name), expected, '"30 µm ± 10 µm"')
                return None
            try:
                clearance = clearance_of_group(table, bearing.bore, name)
            except InputError as error:
                problem = error.problems[0]
                self._refuse(key, problem.found, problem.expected, f'"{problem.nearest or "CN"}"', problem.nearest)
                return None
        fields = {field: getattr(bearing, field) for field in bearing.model_fields_set} | {"clearance": clearance}
        try:
            part = type(bearing).model_validate(fields)
        except ValidationError as error:
            said = error.errors()[0].get("ctx", {})
            self._refuse(key, str(said.get("why", shown(name))), str(said.get("expected", "a clearance: a group, or a length")), '"30 µm ± 10 µm"')
            return None
        if part.model_dump() == bearing.model_dump():
            return Candidate(name, None), price
        return Candidate(name, part, stated=name), price


def _known(*masses: float | None) -> float:
    """Return the first mass that is stated; NaN where none is."""
    return next((mass for mass in masses if mass is not None), math.nan)


def _priced(candidate: Candidate, price: float) -> Candidate:
    return replace(candidate, price=0.0 if math.isnan(price) else price)


def _ratio_of(joint: RevoluteJoint) -> float | None:
    """Give the ratio of the joint's present gearbox; None where nobody stated one."""
    gearbox = joint.gearbox
    if gearbox is None or (isinstance(gearbox, CatalogueGearbox) and "ratio" not in gearbox.model_fields_set):
        return None
    return None if gearbox.ratio is None else abs(float(gearbox.ratio))


def _within(key: str, where: KeyPath) -> str:
    return ".".join([key, *map(str, where)])


def _key(table: str, name: str) -> str:
    return f"sizing.{table}.{key_step(plain(name))}"
