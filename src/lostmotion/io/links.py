"""What links and the base take by name: sections and materials within sections, and compliances
from files beside the arm's.

[sections.forearm]
kind = "stepped"
steps = [{ length = "100 mm", section = "large", material = "steel" }, { length = "300 mm", section
= "small" }]

link = { length = "400 mm", compliance = "forearm.csv" }            # `compliance_csv` says what it
holds
base = { compliance = { file = "mount.csv", scatter = "10 %" } }
"""

from __future__ import annotations

from typing import TYPE_CHECKING, Any, Final

from lostmotion.errors import InputError, shown
from lostmotion.io.compliance_csv import read_compliance
from lostmotion.io.provenance import rename_assumed
from lostmotion.io.text import beside

if TYPE_CHECKING:
    from lostmotion.io.draft import Draft
    from lostmotion.io.validation_errors import Path

# The keys under which sections are made of others, entry by entry, and those that no such other
# has: nothing is made of itself.
_PIECES: Final = {
    "layers": {"layers", "steps", "stations"},
    "steps": {"steps", "stations"},
    "stations": {"layers", "steps", "stations"},
}
_FILE: Final = 'compliance = "forearm.csv"'


def place_links(draft: Draft) -> dict[str, set[str]]:
    """Put parts where sections name them and matrices where links name files; note what is wrong.
    Gives the names used, by table.
    """
    used: dict[str, set[str]] = {"sections": set(), "materials": set()}
    for name, section in _table(draft, "sections").items():
        _place_in(draft, section, ("sections", name), used)
    _place_compliance(draft, draft.tree.get("base"), ("base",))
    for index, joint in draft.joints:
        link = joint.get("link")
        if isinstance(link, dict):
            _place_in(draft, link.get("section"), ("joints", index, "link", "section"), used)
            _place_compliance(draft, link, ("joints", index, "link"))
    return used


def _place_in(draft: Draft, section: Any, path: Path, used: dict[str, set[str]]) -> None:  # noqa: ANN401 - whatever a file holds
    """Put parts into one section, and into the sections stated within it; shared ones have their
    own turn.
    """
    if not isinstance(section, dict):
        return
    for key, ends in _PIECES.items():
        entries = section.get(key)
        for index, entry in enumerate(entries if isinstance(entries, list) else ()):
            if not isinstance(entry, dict) or draft.full:
                continue
            here = (*path, key, index)
            if isinstance(entry.get("material"), str):
                used["materials"].add(
                    draft.fill_in(
                        "materials", _table(draft, "materials"), entry, (*here, "material")
                    )
                )
            if isinstance(entry.get("section"), str):
                known = {
                    name: part
                    for name, part in _table(draft, "sections").items()
                    if not (isinstance(part, dict) and ends & part.keys())
                }
                used["sections"].add(draft.fill_in("sections", known, entry, (*here, "section")))
            else:
                _place_in(draft, entry.get("section"), (*here, "section"), used)


def _table(draft: Draft, name: str) -> dict[str, Any]:
    table = draft.tree.get(name, {})
    return table if isinstance(table, dict) else {}


def _place_compliance(draft: Draft, holder: Any, path: Path) -> None:  # noqa: ANN401 - whatever a file holds
    """Put the matrix of a file where a link or the base names it."""
    if not isinstance(holder, dict) or "compliance" not in holder or draft.full:
        return
    path = (*path, "compliance")
    stated = holder["compliance"]
    table = dict(stated) if isinstance(stated, dict) else {"file": stated}
    if "file" in table:
        rename_assumed(table, {"file": "matrix"})
    name = table.pop("file", None)
    file = beside(draft.file, name)
    numbers = {"matrix", "own_weight"} & table.keys()
    if file is None or numbers:
        found = "a matrix without units" if numbers else shown(stated if name is None else name)
        draft.refuse(
            path,
            found,
            (
                "the name of a CSV in the arm's folder or below it, or a table with `file` and "
                "`scatter`"
            ),
            _FILE,
        )
        holder.pop("compliance")
        return
    try:
        holder["compliance"] = {**table, **read_compliance(file)}
    except InputError as error:
        draft.mistakes += error.problems
        holder.pop("compliance")
