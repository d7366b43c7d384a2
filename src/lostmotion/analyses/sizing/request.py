"""Request for a sizing: limits or a target, and the candidates for each link. Read from a TOML file
of its own.

    [sizing]
    slope = "0.5 arcmin"            # the paper's condition (4), which is the default
    deflection = 2500               # the length of the link over this
    tilt = "10 deg"                 # largest tilt of the base; by default it is as stated
    step = "0.1 mm"                 # step of free sizes, "0 mm": any; by default they are usual
                                    sizes of tubes, bars and profiles
    family = { kind = "tube", outer = "30 mm .. 200 mm", wall = "3 mm" }

    [sizing.links.A]                # by the name of the joint; a range, a size, or a share of the
                                    leading size
    family = { kind = "box", height = "30 mm .. 150 mm", width = "60 % .. 100 %", wall = "2 mm .. 6
    mm" }

    [sizing.links.B]                # a list
    stock = [{ kind = "tube", outer = "80 mm", wall = "2 mm" }, { kind = "tube", outer = "100 mm",
    wall = "2 mm" }]

    [sizing.links.roll]
    keep = true

A link that is not named is sized among sections like its own, for a target from half to twice as
large. `material` states a link's new material.

With `target = "0.5 mm"` the links are sized for the error of the tool, with the gearboxes and
clearances of `selection_options`; slope and deflection are then constraints where they are stated.
`target_of = "rp_iso"` or "rp_any": the target limits RP, ISO cycle, or RP, any approach.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass, replace
from numbers import Real
from typing import TYPE_CHECKING, Annotated, Any, Final

from pydantic import Field, ValidationError, model_validator

from lostmotion.analyses.sizing.candidates import Objective, link_slot
from lostmotion.analyses.sizing.evaluation import Constraints
from lostmotion.analyses.sizing.lightest import Limits
from lostmotion.analyses.sizing.option_tables import OptionTables
from lostmotion.analyses.sizing.selection_options import (
    OBJECTIVE_EXAMPLE,
    OPTION_TABLES,
    parse_objective,
    selection_slots,
)
from lostmotion.analyses.sizing.sizing import PAPER, LinkOptions
from lostmotion.analyses.sizing.target_quantity import TargetOf
from lostmotion.catalogue import materials
from lostmotion.errors import Problem, shown
from lostmotion.io.draft import plain
from lostmotion.io.limits import listed, nearest, refuse_all
from lostmotion.io.own_reducers import take_reducers
from lostmotion.io.toml import key_step, request_of
from lostmotion.io.toml_lines import names_lines
from lostmotion.io.validation_errors import problems
from lostmotion.parts.error_source import Part
from lostmotion.parts.family import Family, family_around
from lostmotion.parts.material import Material
from lostmotion.parts.section import Plain, refuse_section
from lostmotion.units import Quantity

if TYPE_CHECKING:
    from collections.abc import Callable, Sequence
    from pathlib import Path

    from lostmotion.analyses.sizing.candidates import Slot
    from lostmotion.catalogue.gearbox_row import GearboxRow
    from lostmotion.io.validation_errors import Path as KeyPath
    from lostmotion.mechanism.arm import Arm
    from lostmotion.parts.joint import Joint

TABLE: Final = "sizing"
_EXAMPLE: Final = '[sizing] with slope = "0.5 arcmin", deflection = 2500'
_LINK_EXAMPLE: Final = (
    '[sizing.links.A] with family = { kind = "tube", outer = "30 mm .. 200 mm", wall = "3 mm" }'
)
_MOST_LINKS: Final = 100
# Range of sizes around a link's own section, in a selection for a target.
_NEAR_ITS_OWN: Final = (0.5, 2.0)
Stock = Annotated[tuple[Plain, ...], Field(min_length=1, max_length=500)]


class LinkChoice(Part):
    """Options for a link: a family or a list of sections, a new material, or `keep`."""

    family: Family | None = None
    stock: Stock | None = None
    material: Material | None = None
    keep: bool = False

    @model_validator(mode="after")
    def _states_one_choice(self) -> LinkChoice:
        stated = [
            name
            for name, value in (("family", self.family), ("stock", self.stock), ("keep", self.keep))
            if value
        ]
        if len(stated) > 1:
            raise refuse_section(
                " and ".join(stated), "one of family, stock and keep", "keep = true"
            )
        return self


class Plan(LinkChoice):
    """Limits for every link, and options for the links that are not named."""

    slope: Annotated[float, Quantity("rad", "0.5 arcmin", above=0, high=0.1)] = PAPER.slope
    deflection: Annotated[float, Quantity("", "2500", low=10, high=1e9)] = PAPER.deflection
    tilt: Annotated[float, Quantity("rad", "10 deg", low=0, high=math.pi)] | None = None
    step: Annotated[float, Quantity("m", "0.1 mm", low=0, high=0.1)] | None = None
    target: Annotated[float, Quantity("m", "0.5 mm", above=0, high=10)] | None = None
    target_of: TargetOf = "error"
    minimise: Annotated[str, Field(max_length=80)] = "mass"
    price_per_kg: Annotated[float, Quantity("", "12", low=0)] | None = None

    @property
    def limits(self) -> Limits:
        """Return the limits of every link."""
        return Limits(self.slope, self.deflection)


_ALSO: Final[dict[type[Any], dict[str, str]]] = {
    Plan: {"links": _LINK_EXAMPLE, **{table: f"[sizing.{table}]" for table in OPTION_TABLES}},
}
BY_MASS: Final = Objective()
_NUMBERS: Final = ("deflection", "price_per_kg")


@dataclass(frozen=True)
class SizingRequest:
    """A request: limits or a target, options of the links to size by the name of their joint; with
    a target, all slots and the objective.

    notes   for the report
    """

    plan: Plan
    link_options: dict[str, LinkOptions]
    slots: tuple[Slot, ...] = ()
    objective: Objective = BY_MASS
    notes: tuple[str, ...] = ()

    @property
    def constraints(self) -> Constraints:
        """Return the constraints besides the target: limits of the links, where stated."""
        limited = {"slope", "deflection"} & self.plan.model_fields_set
        return Constraints(self.plan.limits if limited else None, self.plan.tilt)


@names_lines
def read_request(
    by: Path | Mapping[str, Any] | None,
    options: Mapping[str, Any],
    arm: Arm,
    own: Sequence[GearboxRow] = (),
) -> SizingRequest:
    """Return the request of a file or dictionary with `[sizing]`, and of `options`, keys of it.

    `own` are the arm file's rows of reducers. Raises InputError with every mistake in file and
    options, also unknown links,
    gearboxes and bearings, and those that cannot be selected.
    """
    file, tree = _content(by)
    options = {key: _worded(key, value) for key, value in options.items()}
    is_empty = by is not None and TABLE not in tree
    stated = tree.pop(TABLE, {})
    in_file, mistakes = take_reducers(file, tree)
    if is_empty:
        mistakes.append(
            Problem(file, TABLE, _MISSING, "a table of limits and of options for links", _EXAMPLE)
        )
    mistakes += [
        Problem(
            file,
            shown(key)[1:-1],
            f"an unknown key with {shown(value)}",
            f"one table [{TABLE}]",
            _EXAMPLE,
            nearest(key, [TABLE]),
        )
        for key, value in list(tree.items())[:_MOST_LINKS]
    ]
    if not isinstance(stated, dict):
        refuse_all([*mistakes, Problem(file, TABLE, shown(stated), "a table", _EXAMPLE)])
    twice = [key for key in options if key in stated]
    mistakes += [
        Problem(file, f"{TABLE}.{key}", "stated here, and as an argument", "one of the two")
        for key in twice
    ]
    merged = {**stated, **options}
    links = merged.pop("links", {})
    tables = {name: merged.pop(name) for name in OPTION_TABLES if name in merged}

    def key_of(where: KeyPath) -> str:
        if where and where[0] in options:
            return str(
                where[1]
                if where[0] == "family" and len(where) > 1 and where[1] in _OPTIONS
                else where[0]
            )
        return _key((TABLE, *where))

    plan = _checked(merged, Plan, file, key_of, mistakes)
    mistakes = _one_for_one(
        mistakes, [key_of(("family", name)) for name in _OPTIONS] if "family" in options else []
    )
    named = _links(links, file, mistakes)
    names = {joint.name: joint for joint in arm.joints}
    for name in named:
        if name not in names:
            known = [joint.name for joint in arm.joints if joint.link.reach]
            mistakes.append(
                Problem(
                    file,
                    _key((TABLE, "links", name)),
                    "no such joint",
                    f"one of {listed(known)}",
                    _LINK_EXAMPLE,
                    nearest(name, known),
                )
            )
    tables_ = _with_objective(
        merged, OptionTables(file, tables, arm, BY_MASS, own, in_file), key_of
    )
    parts = selection_slots(tables_)
    mistakes += tables_.mistakes
    link_options: dict[str, LinkOptions] = {}
    if isinstance(plan, Plan) and not any(
        problem.key.startswith(f"{TABLE}.links") for problem in mistakes
    ):
        link_options = _link_options(plan, named, arm, file, mistakes, needed=not tables)
        if link_options and tables_.objective.per_price and plan.price_per_kg is None:
            expected = (
                "the price per kg of link, because prices are minimised; 0 where links are free"
            )
            mistakes.append(
                Problem(file, f"{TABLE}.price_per_kg", "nothing", expected, "price_per_kg = 12")
            )
    if mistakes or not isinstance(plan, Plan):
        refuse_all(
            [_as_argument(each) if each.key in {*options, *_OPTIONS} else each for each in mistakes]
        )
    return (
        SizingRequest(plan, link_options)
        if plan.target is None
        else _with_target(plan, link_options, tables_, parts)
    )


def _content(by: Path | Mapping[str, Any] | None) -> tuple[str, dict[str, Any]]:
    """Return what messages call the request, and its content; numbers of a dictionary are in SI."""
    file, tree = ("", {}) if by is None else request_of(by, TABLE)
    if isinstance(by, Mapping) and isinstance(tree[TABLE], dict):
        tree[TABLE] = {key: _worded(key, value) for key, value in tree[TABLE].items()}
    return file, tree


def _with_objective(
    merged: dict[str, Any], offers: OptionTables, key_of: Callable[[KeyPath], str]
) -> OptionTables:
    """Return the tables with their objective; mistakes are an objective that cannot be read, and
    options without a target.
    """
    alone = [
        *offers.tables,
        *(name for name in ("minimise", "price_per_kg", "target_of") if name in merged),
    ]
    if alone and "target" not in merged:
        expected = "a target on the tool as well; without one, links are sized by limits"
        offers.mistakes.append(
            Problem(offers.file, f"{TABLE}.{alone[0]}", "no target", expected, 'target = "0.5 mm"')
        )
    objective = parse_objective(str(merged.get("minimise", "mass")))
    if objective is None:
        expected = "mass, price, or a sum of both with factors"
        offers.mistakes.append(
            Problem(
                offers.file,
                key_of(("minimise",)),
                shown(merged["minimise"]),
                expected,
                OBJECTIVE_EXAMPLE,
            )
        )
    offers.objective = objective or BY_MASS
    return offers


def _with_target(
    plan: Plan, link_options: dict[str, LinkOptions], offers: OptionTables, parts: list[Slot]
) -> SizingRequest:
    """Return the request for a target: sections of links and other parts in the order of the
    joints.
    """
    order = {joint.name: k for k, joint in enumerate(offers.arm.joints)}
    joints = {joint.name: joint for joint in offers.arm.joints}
    sections = [
        link_slot(joints[name], each.choice, each.material, plan.step, plan.price_per_kg or 0.0)
        for name, each in link_options.items()
    ]
    slots = sorted([*parts, *sections], key=lambda slot: order[slot.joint])
    return SizingRequest(plan, link_options, tuple(slots), offers.objective, tuple(offers.notes))


# Keys of a family that are arguments of the question.
_OPTIONS: Final = ("outer", "wall")
# Keys of the table that are quantities with a unit.
_UNITS: Final = {"slope": "rad", "tilt": "rad", "step": "m", "target": "m"}
_MISSING: Final = "nothing"


def _one_for_one(mistakes: list[Problem], keys: Sequence[str]) -> list[Problem]:
    """Return the mistakes without missing values of these keys where another of them is wrong: one
    wrong size of two is one mistake.
    """
    wrong = any(each.key in keys and each.found != _MISSING for each in mistakes)
    return [
        each for each in mistakes if not (wrong and each.key in keys and each.found == _MISSING)
    ]


def _as_argument(mistake: Problem) -> Problem:
    """Return a mistake in an option as one of the argument."""
    name, _, value = mistake.example.partition(" = ")
    passing = ((name, value.strip('"')),) if name == mistake.key and value[:1] == '"' else ()
    return replace(mistake, file="", example="" if passing else mistake.example, passing=passing)


def _worded(name: str, value: Any) -> Any:  # noqa: ANN401 - values of a file's table
    """Return numbers in SI as text with their unit, as a file has them; anything else as it is."""
    if name in _UNITS:
        return f"{float(value)!r} {_UNITS[name]}" if _is_number(value) else value
    if name == "family" and isinstance(value, dict):
        return {size: _size(each) for size, each in value.items()}
    if name == "stock" and isinstance(value, list | tuple):
        return [_worded("family", each) for each in value]
    if name == "links" and isinstance(value, dict):
        return {
            joint: {key: _worded(key, each) for key, each in stated.items()}
            if isinstance(stated, dict)
            else stated
            for joint, stated in value.items()
        }
    return value


def _size(value: Any) -> Any:  # noqa: ANN401 - a size, or a range of it
    if _is_number(value):
        return f"{float(value)!r} m"
    return " .. ".join(str(_size(each)) for each in value) if isinstance(value, tuple) else value


def _is_number(value: object) -> bool:
    return isinstance(value, Real) and not isinstance(value, bool)


def _key(path: KeyPath) -> str:
    out = ""
    for step in path:
        out += (
            f"[{step}]"
            if isinstance(step, int)
            else f".{key_step(plain(step))}"
            if out
            else key_step(plain(step))
        )
    return out


def _checked(
    tree: dict[str, Any],
    model: type[LinkChoice],
    file: str,
    key_of: Any,  # noqa: ANN401
    mistakes: list[Problem],
) -> LinkChoice | None:
    """Check a table by its model; material may go by name."""
    known = materials()
    tree = {
        key: f"{value}" if key in _NUMBERS and type(value) in {int, float} else value
        for key, value in tree.items()
    }
    material = tree.get("material")
    if isinstance(material, str):
        if material in known:
            tree = {**tree, "material": known[material]}
        else:
            near = nearest(material, known)
            expected = f"a material of the catalogue: {listed(known)}; or a table"
            mistakes.append(
                Problem(
                    file,
                    key_of(("material",)),
                    shown(material),
                    expected,
                    f'material = "{near or "aluminium"}"',
                    near,
                )
            )
            tree = {key: value for key, value in tree.items() if key != "material"}
    try:
        return model.model_validate(tree, context={"text": True})
    except ValidationError as error:
        mistakes += problems(error, model, file, key_of, _ALSO)
        return None


def _links(links: Any, file: str, mistakes: list[Problem]) -> dict[str, LinkChoice]:  # noqa: ANN401 - whatever a file holds
    if not isinstance(links, dict) or len(links) > _MOST_LINKS:
        found = shown(links) if not isinstance(links, dict) else f"{len(links)} links"
        mistakes.append(
            Problem(
                file,
                f"{TABLE}.links",
                found,
                "a table of links by the name of their joint",
                _LINK_EXAMPLE,
            )
        )
        return {}
    out = {}
    for name, stated in links.items():
        if not isinstance(stated, dict):
            mistakes.append(
                Problem(file, _key((TABLE, "links", name)), shown(stated), "a table", _LINK_EXAMPLE)
            )
            continue
        choice = _checked(
            stated,
            LinkChoice,
            file,
            lambda where, name=name: _key((TABLE, "links", name, *where)),
            mistakes,
        )
        if choice is not None:
            out[name] = choice
    return out


def _link_options(
    plan: Plan,
    named: dict[str, LinkChoice],
    arm: Arm,
    file: str,
    mistakes: list[Problem],
    *,
    needed: bool,
) -> dict[str, LinkOptions]:
    """Return the options of each link to size; mistakes are named links that cannot be sized, and
    no link where one is needed.
    """
    before = len(mistakes)
    out: dict[str, LinkOptions] = {}
    for joint in arm.joints:
        own = named.get(joint.name)
        options = own if own is not None and (own.family or own.stock or own.keep) else plan
        if options.keep:
            continue
        material = (own.material if own is not None else None) or plan.material
        section = joint.link.section
        choice = options.family or options.stock
        if choice is None:
            choice = (
                family_around(section)
                if plan.target is None
                else family_around(section, *_NEAR_ITS_OWN)
            )
        missing = _missing(joint, has_choice=choice is not None, has_material=material is not None)
        if missing and own is not None:
            mistakes.append(Problem(file, _key((TABLE, "links", joint.name)), *missing))
        elif not missing and choice is not None:
            out[joint.name] = LinkOptions(choice, material)
    if needed and not out and len(mistakes) == before:
        expected = (
            "at least one link with a section and a material, or a family and a material for one "
            "without"
        )
        mistakes.append(
            Problem(
                file, TABLE, "no link to size", expected, 'material = "aluminium" beside the family'
            )
        )
    return out


def _missing(joint: Joint, *, has_choice: bool, has_material: bool) -> tuple[str, str, str] | None:
    link = joint.link
    if not link.reach:
        return "a link without a length", "a link with a length", "keep = true"
    if not has_choice:
        return (
            "a link without a section of stated sizes, and no family",
            "a family or stock",
            _LINK_EXAMPLE,
        )
    if not has_material and (link.section is None or link.material is None):
        return "a link without one material", "its material", 'material = "aluminium"'
    return None
