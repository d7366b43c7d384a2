"""From a draft to an arm: shared parts go where joints name them, and the model checks the
whole.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, Any, Final

from pydantic import ValidationError

from lostmotion.errors import Problem, shown
from lostmotion.io.clearances import ALSO as IN_BEARINGS
from lostmotion.io.clearances import place_clearances
from lostmotion.io.draft import STAND_IN, Draft, step_of
from lostmotion.io.limits import MOST_MISTAKES, listed, refuse_all
from lostmotion.io.links import place_links
from lostmotion.io.own_reducers import OWN_EXAMPLES
from lostmotion.io.presets import TABLE, TABLE_EXAMPLE, place_presets
from lostmotion.io.reducers import ALSO as IN_GEARBOXES
from lostmotion.io.reducers import place_reducers
from lostmotion.io.text import refuse
from lostmotion.io.validation_errors import problems
from lostmotion.mechanism.arm import Arm
from lostmotion.parts.error_source import Part
from lostmotion.parts.passive_joints import BallSocket, SphericalJoint
from lostmotion.parts.profile import Section

if TYPE_CHECKING:
    from lostmotion.io.validation_errors import Path

# Tables of parts that joints refer to by name, and where in a joint the reference stands.
SHARED: Final[dict[str, tuple[str, ...]]] = {
    "gearboxes": ("gearbox",),
    "bearings": ("bearing",),
    "encoders": ("encoder",),
    "sections": ("link", "section"),
    "materials": ("link", "material"),
}
# Keys by which drawings of gearboxes name materials, in themselves, in their members and in their
# first stage.
MATERIALS_OF_GEARBOXES: Final = ("disc_material", "ring_material", "material", "core")
_BALL: Final = BallSocket.model_fields["kind"].default
_TYPES: Final = ("revolute", "prismatic", "fixed", "spherical", "universal", "free")
# What a file may ask for besides an arm; a command of its own does it.
SWEEP: Final = "sweep"
SWEEP_EXAMPLE: Final = '[sweep] with "gearboxes.NAME.backlash" = ["0.5 arcmin", "1 arcmin"]'
SHARED_EXAMPLES: Final = {
    "gearboxes": '[gearboxes.NAME] with backlash = "1 arcmin"',
    "bearings": '[bearings.NAME] with kind = "rolling", span = "40 mm"',
    "encoders": '[encoders.NAME] with side = "motor"',
    "sections": '[sections.NAME] with kind = "tube", outer = "60 mm", wall = "3 mm"',
    "materials": '[materials.NAME] with young = "70 GPa", poisson = 0.33',
    **OWN_EXAMPLES,
    TABLE: TABLE_EXAMPLE,
    SWEEP: SWEEP_EXAMPLE,
}
# No arm has as many, shared parts counted wherever they are used; a hostile file would have them
# all checked one by one.
_MOST_ENTRIES: Final = 20_000


class _Alone(Part):
    """A section by itself, without the link whose length and material it must fit."""

    section: Section


def build_arm(draft: Draft) -> Arm:
    """Return the arm that a draft describes. Raises InputError with every mistake found while
    reading and by the model.
    """
    if draft.tree.pop(SWEEP, None) is not None:
        draft.note("the arm as it stands: its [sweep] is carried out by `lostmotion sweep`")
    _fill_in_shared_parts(draft)
    _check_size(draft)
    try:
        arm = Arm.model_validate(draft.tree, context={"text": True})
    except ValidationError as error:
        draft.mistakes += problems(
            error, Arm, draft.file, draft.key, {**IN_GEARBOXES, **IN_BEARINGS, **draft.also}
        )
    if draft.mistakes:
        refuse_all(draft.mistakes)
    _name_shared_parts(draft, arm)
    return arm


def _name_shared_parts(draft: Draft, arm: Arm) -> None:
    """Name the shared parts by the keys under which the file describes them."""
    for path, key in draft.written.items():
        # materials have names of their own
        if key.partition(".")[0] not in SHARED.keys() - {"materials"}:
            continue
        part: Any = arm
        for step in path:
            if part is not None:
                part = part[step] if isinstance(step, int) else getattr(part, str(step), None)
        if isinstance(part, Part):
            part.__dict__["shared_name"] = key


def _fill_in_shared_parts(draft: Draft) -> None:
    """Put the shared parts where joints name them; note names that lead nowhere, and shared parts
    that nobody names.
    """
    place_presets(draft)
    place_reducers(draft)
    place_clearances(draft)
    named = place_links(draft)
    of_gearboxes = _fill_in_materials_of_gearboxes(draft)
    unused = []
    for table, steps in SHARED.items():
        stock = _stock(draft, table)
        used = named.get(table, set()) | (of_gearboxes if table == "materials" else set())
        for index, joint in draft.joints:
            holder = joint
            for step in steps[:-1]:
                holder = holder.get(step, {})
            if isinstance(holder, dict) and steps[-1] in holder and not draft.full:
                name = draft.fill_in(table, stock, holder, ("joints", index, *steps))
                # The model does not check the parts of a joint whose type it does not know.
                used |= {name} if joint.get("type") in _TYPES else set()
        idle = [name for name in stock if name not in used]
        unused += [f"{table}.{step_of(name)}" for name in idle]
        for name in idle[:MOST_MISTAKES]:
            _check_unused(draft, table, name, stock[name])
    if unused:
        draft.note(f"described and used by no joint: {listed(unused)}")


def _fill_in_materials_of_gearboxes(draft: Draft) -> set[str]:
    """Put materials where drawings of gearboxes name them, also in gearboxes that no joint uses,
    and return their names.
    """
    stock, shared = draft.tree.get("materials", {}), draft.tree.get("gearboxes", {})
    stock = stock if isinstance(stock, dict) else {}
    spots: list[tuple[Path, Any]] = [
        (("joints", index, "gearbox"), joint.get("gearbox")) for index, joint in draft.joints
    ]
    spots += (
        [(("gearboxes", name), gearbox) for name, gearbox in shared.items()]
        if isinstance(shared, dict)
        else []
    )
    places = [place for path, gearbox in spots for place in _materials_named(path, gearbox)]
    return {
        draft.fill_in("materials", stock, holder, path) for holder, path in places if not draft.full
    }


def _materials_named(path: Path, table: Any) -> list[tuple[dict[str, Any], Path]]:  # noqa: ANN401 - whatever a file holds
    """Return the tables in a drawing that name a material, each with the path of that name."""
    if isinstance(table, list):
        return [
            place
            for index, each in enumerate(table)
            for place in _materials_named((*path, index), each)
        ]
    if not isinstance(table, dict):
        return []
    here = [
        (table, (*path, key)) for key in MATERIALS_OF_GEARBOXES if isinstance(table.get(key), str)
    ]
    return here + [
        place for key, each in table.items() for place in _materials_named((*path, key), each)
    ]


def _stock(draft: Draft, table: str) -> dict[str, Any]:
    stock = draft.tree.pop(table, {})
    if isinstance(stock, dict):
        return stock
    draft.refuse((table,), shown(stock), "a table of named parts", SHARED_EXAMPLES[table])
    return {}


def _check_unused(draft: Draft, table: str, name: str, part: Any) -> None:  # noqa: ANN401 - whatever a file holds
    """Note the mistakes in a shared part that no joint names yet, as if a joint did: one that
    turns, or else one that slides; a ball joint for a ball.
    """
    if isinstance(part, dict) and "catalogue" in part:
        return
    if table == "sections":
        _check_alone(draft, _Alone, {"section": part}, "section", f"sections.{step_of(name)}")
        return
    if table == "bearings" and isinstance(part, dict) and part.get("kind") == _BALL:
        ball = {"name": "unused", "type": "spherical", "bearing": part}
        _check_alone(draft, SphericalJoint, ball, "bearing", f"bearings.{step_of(name)}")
        return
    steps = SHARED[table]
    link = {"length": "1 m", "section": STAND_IN["sections"], "material": STAND_IN["materials"]}
    found: list[Problem] = []
    for kind, limits in (("revolute", ["0 deg", "1 deg"]), ("prismatic", ["0 mm", "1 mm"])):
        joint: dict[str, Any] = {"name": "unused", "type": kind, "limits": limits}
        holder = joint
        if len(steps) > 1:
            holder = joint["link"] = dict(link)
        holder[steps[-1]] = part
        trial = Draft(
            draft.file,
            {"name": "unused", "joints": [joint]},
            draft.also,
            {("joints", 0, *steps): f"{table}.{step_of(name)}"},
        )
        try:
            Arm.model_validate(trial.tree, context={"text": True})
        except ValidationError as error:
            found = found or problems(
                error, Arm, draft.file, trial.key, {**IN_GEARBOXES, **IN_BEARINGS, **draft.also}
            )
        else:
            return
    if not draft.full:
        draft.mistakes += found


def _check_alone(
    draft: Draft, model: type[Part], tree: dict[str, Any], place: str, key: str
) -> None:
    """Note the mistakes in a shared part at this place of a model, as mistakes in its key."""
    trial = Draft(draft.file, {}, draft.also, {(place,): key})
    try:
        model.model_validate(tree, context={"text": True})
    except ValidationError as error:
        if not draft.full:
            draft.mistakes += problems(error, model, draft.file, trial.key)


def _check_size(draft: Draft) -> None:
    """Refuse more entries than could be checked in a moment."""
    waiting: list[Any] = [draft.tree]
    count = 0
    while waiting:
        inner = waiting.pop()
        count += len(inner)
        if count > _MOST_ENTRIES:
            refuse(
                draft.file,
                "",
                f"more than {_MOST_ENTRIES} entries",
                "an arm of fewer, shared parts counted wherever they are used",
                "one arm",
            )
        waiting += [
            value
            for value in (inner.values() if isinstance(inner, dict) else inner)
            if isinstance(value, dict | list)
        ]
