"""An arm being read: the tree made from its files, the key under which the user wrote each piece,
and the mistakes found so far.
"""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any, Final

from lostmotion.catalogue import materials
from lostmotion.errors import Problem, shown
from lostmotion.io.limits import MOST_MISTAKES, cut, listed, nearest
from lostmotion.io.toml import key_step, quoted
from lostmotion.mechanism.arm import LONGEST_NOTE, MOST_NOTES
from lostmotion.parts.material import Material
from lostmotion.parts.section import Rod

if TYPE_CHECKING:
    from collections.abc import Mapping

    from pydantic import BaseModel

    from lostmotion.io.validation_errors import Path

LONGEST_SHOWN: Final = 80
# Replaces a reference to a missing part, so that the rest of the link is still checked.
STAND_IN: Final = {
    "sections": Rod(diameter=1.0),
    "materials": Material(young=1.0, poisson=0.3, density=1.0),
}


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
        """Return the key under which the user wrote this."""
        kept = next(
            (length for length in range(len(path), 0, -1) if path[:length] in self.written), 0
        )
        key = self.written.get(path[:kept], "")
        for step in path[kept:]:
            key += (
                f"[{step}]"
                if isinstance(step, int)
                else f".{step_of(step)}"
                if key
                else step_of(step)
            )
        return key

    def refuse(self, path: Path, *words: str) -> None:
        """Note a mistake: what was found, what is expected, an example, and the nearest name."""
        if not self.full:
            self.mistakes.append(Problem(self.file, self.key(path), *words))

    @property
    def full(self) -> bool:
        """Return whether more mistakes are known than will be listed: no need to look for
        others.
        """
        return len(self.mistakes) > MOST_MISTAKES

    def note(self, text: str) -> None:
        """Add a line to the arm's notes, once."""
        notes = self.tree.get("notes", [])
        text = cut(text, LONGEST_NOTE)
        if isinstance(notes, list) and len(notes) < MOST_NOTES and text not in notes:
            self.tree["notes"] = [*notes, text]

    @property
    def joints(self) -> list[tuple[int, dict[str, Any]]]:
        """Return the joints that are tables, with their positions; anything else is refused later,
        by the model.
        """
        return [
            (index, joint)
            for index, joint in enumerate(self.tree.get("joints", ()))
            if isinstance(joint, dict)
        ]

    def fill_in(self, table: str, stock: dict[str, Any], holder: dict[str, Any], path: Path) -> str:
        """Replace one reference by the part that it names, and return the name; empty where there
        is none.
        """
        last = str(path[-1])
        stated = holder[last]
        if isinstance(stated, dict):
            return ""
        known = {**materials(), **stock} if table == "materials" else stock
        if isinstance(stated, str) and stated in known:
            part = known[stated]
            holder[last] = (
                {"name": plain(stated), **part}
                if table == "materials" and isinstance(part, dict)
                else part
            )
            self.written[path] = f"{table}.{step_of(stated)}"
            return stated
        near = nearest(stated, known) if isinstance(stated, str) else ""
        example = f"{last} = {quoted(near or next(iter(known)))}" if known else f"[{table}.NAME]"
        names = listed(known, plain) or "none is there"
        expected = (
            f"a name under [{table}]: {names}"
            if isinstance(stated, str)
            else f"a table, or a name under [{table}]"
        )
        self.refuse(path, shown(stated), expected, example, near)
        holder.pop(last)
        if table in STAND_IN:
            holder[last] = STAND_IN[table]
        return ""


def plain(name: str) -> str:
    """Show a name from a file within a sentence, whatever it holds."""
    return cut(name, LONGEST_SHOWN)


def step_of(name: str) -> str:
    """Return a name from a file as a step of a key."""
    return key_step(plain(name))
