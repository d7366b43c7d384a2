"""An arm in the making: what the files say, which key the user wrote each piece under, and the mistakes found so far."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any, Final

from pydantic import ValidationError

from lostmotion.catalogue import materials
from lostmotion.errors import Problem, shown
from lostmotion.io.clearances import ALSO as IN_BEARINGS
from lostmotion.io.clearances import place_clearances
from lostmotion.io.limits import MOST_MISTAKES, cut, listed, nearest, refuse_all
from lostmotion.io.links import place_links
from lostmotion.io.own_reducers import OWN_EXAMPLES
from lostmotion.io.reducers import ALSO as IN_GEARBOXES
from lostmotion.io.reducers import place_reducers
from lostmotion.io.text import refuse
from lostmotion.io.toml import key_step, quoted
from lostmotion.io.validation_errors import problems
from lostmotion.mechanism.serial import LONGEST_NOTE, MOST_NOTES, Arm
from lostmotion.parts.error_source import Part
from lostmotion.parts.material import Material
from lostmotion.parts.profile import Section
from lostmotion.parts.section import Rod

if TYPE_CHECKING:
    from collections.abc import Mapping

    from pydantic import BaseModel

    from lostmotion.io.validation_errors import Path

# Tables of parts that joints refer to by name, and where in a joint the reference stands.
SHARED: Final[dict[str, tuple[str, ...]]] = {
    "gearboxes": ("gearbox",),
    "bearings": ("bearing",),
    "encoders": ("encoder",),
    "sections": ("link", "section"),
    "materials": ("link", "material"),
}
# Where drawings of gearboxes name materials, in themselves and in their first stage.
MATERIALS_OF_GEARBOXES: Final = ("disc_material", "ring_material")
_FIRST: Final = "first_stage"
LONGEST_SHOWN: Final = 80
# What a file may ask for besides an arm; a command of its own does it.
SWEEP: Final = "sweep"
SWEEP_EXAMPLE: Final = '[sweep] with "gearboxes.NAME.backlash" = ["0.5 arcmin", "1 arcmin"]'
SHARED_EXAMPLES: Final = {**{table: f"[{table}.NAME]" for table in SHARED}, **OWN_EXAMPLES, SWEEP: SWEEP_EXAMPLE}
# No arm has as many, shared parts counted wherever they are used; a hostile file would have them all checked one by one.
_MOST_ENTRIES: Final = 20_000
# Stands where a reference led nowhere, so that the rest of the link is still checked.
_STAND_IN: Final = {"sections": Rod(diameter=1.0), "materials": Material(young=1.0, poisson=0.3, density=1.0)}


class _Alone(Part):
    """A section by itself, without the link whose length and material it must fit."""

    section: Section


@dataclass
class Draft:
    """A tree with Arm's fields, made from `file`.

    also      keys that the format takes besides the fields of a model, with an example of each
    written   the user's key of every piece that stands elsewhere in the file
    """

    file: str
    tree: dict[str, Any]
    also: Mapping[type[BaseModel], Mapping[str, str]]
    written: dict[Path, str] = field(default_factory=dict)
    mistakes: list[Problem] = field(default_factory=list)

    def key(self, path: Path) -> str:
        """Under which key did the user write this?"""
        kept = next((length for length in range(len(path), 0, -1) if path[:length] in self.written), 0)
        key = self.written.get(path[:kept], "")
        for step in path[kept:]:
            key += f"[{step}]" if isinstance(step, int) else f".{_step(step)}" if key else _step(step)
        return key

    def refuse(self, path: Path, *words: str) -> None:
        """Note a mistake: what was found, what is expected, an example, and the nearest name."""
        if not self.full:
            self.mistakes.append(Problem(self.file, self.key(path), *words))

    @property
    def full(self) -> bool:
        """Tell whether more mistakes are known than will be listed: no need to look for others."""
        return len(self.mistakes) > MOST_MISTAKES

    def note(self, text: str) -> None:
        """Add a line to what the arm's own notes say; once, however often it is said."""
        notes = self.tree.get("notes", [])
        text = cut(text, LONGEST_NOTE)
        if isinstance(notes, list) and len(notes) < MOST_NOTES and text not in notes:
            self.tree["notes"] = [*notes, text]

    @property
    def joints(self) -> list[tuple[int, dict[str, Any]]]:
        """Give the joints that are tables, with their positions; anything else is refused later, by the model."""
        return [(index, joint) for index, joint in enumerate(self.tree.get("joints", ())) if isinstance(joint, dict)]

    def fill_in_shared_parts(self) -> None:
        """Put the shared parts where joints name them; note names that lead nowhere, and shared parts that nobody names."""
        place_reducers(self)
        place_clearances(self)
        named = place_links(self)
        of_gearboxes = self._fill_in_materials_of_gearboxes()
        unused = []
        for table, steps in SHARED.items():
            stock = self._stock(table)
            used = named.get(table, set()) | (of_gearboxes if table == "materials" else set())
            for index, joint in self.joints:
                holder = joint
                for step in steps[:-1]:
                    holder = holder.get(step, {})
                if isinstance(holder, dict) and steps[-1] in holder and not self.full:
                    used.add(self.fill_in(table, stock, holder, ("joints", index, *steps)))
            idle = [name for name in stock if name not in used]
            unused += [f"{table}.{_step(name)}" for name in idle]
            for name in idle[:MOST_MISTAKES]:
                self._check_unused(table, name, stock[name])
        if unused:
            self.note(f"described and used by no joint: {listed(unused)}")

    def _fill_in_materials_of_gearboxes(self) -> set[str]:
        """Put materials where drawings of gearboxes name them, also in gearboxes that nobody uses, and give the names."""
        stock, shared = self.tree.get("materials", {}), self.tree.get("gearboxes", {})
        stock = stock if isinstance(stock, dict) else {}
        spots: list[tuple[Path, Any]] = [(("joints", index, "gearbox"), joint.get("gearbox")) for index, joint in self.joints]
        spots += [(("gearboxes", name), gearbox) for name, gearbox in shared.items()] if isinstance(shared, dict) else []
        spots += [((*path, _FIRST), gearbox.get(_FIRST)) for path, gearbox in spots if isinstance(gearbox, dict)]
        return {
            self.fill_in("materials", stock, holder, (*path, key))
            for path, holder in spots
            if isinstance(holder, dict)
            for key in MATERIALS_OF_GEARBOXES
            if isinstance(holder.get(key), str) and not self.full
        }

    def _stock(self, table: str) -> dict[str, Any]:
        stock = self.tree.pop(table, {})
        if isinstance(stock, dict):
            return stock
        self.refuse((table,), shown(stock), "a table of named parts", f"[{table}.NAME]")
        return {}

    def fill_in(self, table: str, stock: dict[str, Any], holder: dict[str, Any], path: Path) -> str:
        """Replace one reference by the part it names, and give the name; empty where there is none."""
        last = str(path[-1])
        stated = holder[last]
        if isinstance(stated, dict):
            return ""
        known = {**materials(), **stock} if table == "materials" else stock
        if isinstance(stated, str) and stated in known:
            holder[last] = known[stated]
            self.written[path] = f"{table}.{_step(stated)}"
            return stated
        near = nearest(stated, known) if isinstance(stated, str) else ""
        example = f"{last} = {quoted(near or next(iter(known)))}" if known else f"[{table}.NAME]"
        names = listed(known, plain) or "none is there"
        expected = f"a name under [{table}]: {names}" if isinstance(stated, str) else f"a table, or a name under [{table}]"
        self.refuse(path, shown(stated), expected, example, near)
        holder.pop(last)
        if table in _STAND_IN:
            holder[last] = _STAND_IN[table]
        return ""

    def _check_unused(self, table: str, name: str, part: Any) -> None:  # noqa: ANN401 - whatever a file holds
        """Note the mistakes in a shared part that no joint names yet, as if a joint did: one that turns, or else one that slides."""
        if isinstance(part, dict) and "catalogue" in part:
            return
        if table == "sections":
            self._check_section(name, part)
            return
        steps = SHARED[table]
        link = {"length": "1 m", "section": _STAND_IN["sections"], "material": _STAND_IN["materials"]}
        found: list[Problem] = []
        for kind, limits in (("revolute", ["0 deg", "1 deg"]), ("prismatic", ["0 mm", "1 mm"])):
            joint: dict[str, Any] = {"name": "unused", "type": kind, "limits": limits}
            holder = joint
            if len(steps) > 1:
                holder = joint["link"] = dict(link)
            holder[steps[-1]] = part
            trial = Draft(self.file, {"name": "unused", "joints": [joint]}, self.also, {("joints", 0, *steps): f"{table}.{_step(name)}"})
            try:
                Arm.model_validate(trial.tree, context={"text": True})
            except ValidationError as error:
                found = found or problems(error, Arm, self.file, trial.key, {**IN_GEARBOXES, **IN_BEARINGS, **self.also})
            else:
                return
        if not self.full:
            self.mistakes += found

    def _check_section(self, name: str, part: Any) -> None:  # noqa: ANN401 - whatever a file holds
        trial = Draft(self.file, {}, self.also, {("section",): f"sections.{_step(name)}"})
        try:
            _Alone.model_validate({"section": part}, context={"text": True})
        except ValidationError as error:
            if not self.full:
                self.mistakes += problems(error, _Alone, self.file, trial.key)

    def arm(self) -> Arm:
        """Which arm is it? Raises InputError with every mistake noted on the way and every one that the model finds."""
        if self.tree.pop(SWEEP, None) is not None:
            self.note("the arm as it stands: its [sweep] is carried out by `lostmotion sweep`")
        self.fill_in_shared_parts()
        self._check_size()
        try:
            arm = Arm.model_validate(self.tree, context={"text": True})
        except ValidationError as error:
            self.mistakes += problems(error, Arm, self.file, self.key, {**IN_GEARBOXES, **IN_BEARINGS, **self.also})
        if self.mistakes:
            refuse_all(self.mistakes)
        return arm

    def _check_size(self) -> None:
        """Refuse more entries than could be checked in a moment."""
        waiting: list[Any] = [self.tree]
        count = 0
        while waiting:
            inner = waiting.pop()
            count += len(inner)
            if count > _MOST_ENTRIES:
                refuse(self.file, "", f"more than {_MOST_ENTRIES} entries", "an arm of fewer, shared parts counted wherever they are used", "one arm")
            waiting += [value for value in (inner.values() if isinstance(inner, dict) else inner) if isinstance(value, dict | list)]


def plain(name: str) -> str:
    """Show a name from a file within a sentence, whatever it holds."""
    return cut(name, LONGEST_SHOWN)


def _step(name: str) -> str:
    """Show a name from a file as a step of a key."""
    return key_step(plain(name))
