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
clearances of `sizing_options`; slope and deflection are then constraints where they are stated.
`target_of = "rp_iso"` or "rp_any": the target limits RP, ISO cycle, or RP, any approach.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace
from numbers import Real
from typing import TYPE_CHECKING, Any, Final

from lostmotion.errors import Problem, shown
from lostmotion.io.limits import listed, nearest, refuse_all
from lostmotion.io.own_reducers import take_reducers
from lostmotion.io.sizing_links import (
    LINK_EXAMPLE,
    MOST_LINKS,
    TABLE,
    Plan,
    checked_table,
    key_text,
    link_options_of,
    links_of,
)
from lostmotion.io.sizing_options import (
    OBJECTIVE_EXAMPLE,
    OPTION_TABLES,
    OptionTables,
    parse_objective,
)
from lostmotion.io.sizing_parts import selection_slots
from lostmotion.io.toml import request_of
from lostmotion.io.toml_lines import names_lines
from lostmotion.sizing.candidates import LinkOptions, Objective, for_copies, link_slot
from lostmotion.sizing.evaluation import Constraints

if TYPE_CHECKING:
    from collections.abc import Callable, Sequence
    from pathlib import Path

    from lostmotion.catalogue.gearbox_row import GearboxRow
    from lostmotion.io.validation_errors import Path as KeyPath
    from lostmotion.mechanism.arm import Arm
    from lostmotion.sizing.candidates import Slot

_EXAMPLE: Final = '[sizing] with slope = "0.5 arcmin", deflection = 2500'


BY_MASS: Final = Objective()


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
        for key, value in list(tree.items())[:MOST_LINKS]
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
        return key_text((TABLE, *where))

    plan = checked_table(merged, Plan, file, key_of, mistakes)
    mistakes = _one_for_one(
        mistakes, [key_of(("family", name)) for name in _OPTIONS] if "family" in options else []
    )
    named = links_of(links, file, mistakes)
    names = {joint.name: joint for joint in arm.joints}
    for name in named:
        if name not in names:
            known = [joint.name for joint in arm.joints if joint.link.reach]
            mistakes.append(
                Problem(
                    file,
                    key_text((TABLE, "links", name)),
                    "no such joint",
                    f"one of {listed(known)}",
                    LINK_EXAMPLE,
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
        link_options = link_options_of(plan, named, arm, file, mistakes, needed=not tables)
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
    slots = for_copies(sorted([*parts, *sections], key=lambda slot: order[slot.joint]), offers.arm)
    return SizingRequest(plan, link_options, slots, offers.objective, tuple(offers.notes))


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
    if isinstance(value, tuple | list):
        return " .. ".join(str(_size(each)) for each in value)
    return value


def _is_number(value: object) -> bool:
    return isinstance(value, Real) and not isinstance(value, bool)
