"""The sized arm as a file: the user's own text with other sections in it, comments kept."""

from __future__ import annotations

import math
import tomllib
from pathlib import Path
from typing import TYPE_CHECKING, Any, Final

from lostmotion.errors import InputError
from lostmotion.formats.allowed import inside
from lostmotion.formats.text import read_text
from lostmotion.formats.toml import MEGABYTES
from lostmotion.units import Quantity

if TYPE_CHECKING:
    from lostmotion.parts.source import Part
    from lostmotion.studies.sizing import Sizing

# What gives way to a section in a link's table.
_INSTEAD: Final = ("compliance", "measured")
_MM: Final = {"m": (1e3, "mm")}


def sized_text(source: str | Path, sidecar: str | Path | None, found: Sizing) -> str:
    """Which text describes the sized arm, in the place of the file that the arm was read from, or of the URDF's sidecar?"""
    path = Path(source)
    if path.suffix.lower() != ".toml":
        from lostmotion.formats.sidecar import find_sidecar

        return sized_toml(find_sidecar(path) if sidecar is None else Path(sidecar), found)
    return sized_toml(path, found)


def sized_toml(source: Path | None, found: Sizing) -> str:
    """Which text describes the sized arm as `source` describes the stated one?

    `source` is the arm's TOML, or the sidecar of a URDF (None where it has none: then the text is a sidecar of its own). Every link that was sized
    states its section in its own table; shared sections that nobody names any more go.
    """
    import tomlkit

    text = read_text(source, MEGABYTES) if source is not None else ""
    wanted = tomllib.loads(text)
    _put(wanted, found, plain=True)
    try:
        document: Any = tomlkit.parse(text)
        _put(document, found, plain=False)
        out = tomlkit.dumps(document)
        if tomllib.loads(out) == wanted:
            return out
    except (ValueError, KeyError, TypeError, AttributeError, tomlkit.exceptions.TOMLKitError):
        pass  # a layout that tomlkit cannot change in place: the same tables without the user's comments
    return tomlkit.dumps(wanted)


def _put(tree: Any, found: Sizing, *, plain: bool) -> None:  # noqa: ANN401 - a tree of dicts, or tomlkit's own
    stated = {joint.name: joint for joint in found.arm.joints}
    sized = {joint.name: joint for joint in found.sized.joints}
    for each in found.links:
        joint = _joint(tree, each.joint)
        link = joint.setdefault("link", {})
        for key in _INSTEAD:
            link.pop(key, None)
        link["section"] = _table(stated_by(each.section), plain=plain)
        before, after = stated[each.joint].link, sized[each.joint].link
        if after.material != before.material and after.material is not None:
            link["material"] = _table(stated_by(after.material), plain=plain)
        if after.mass is not None:
            link["mass"] = f"{after.mass:.12g} kg"
    _drop_idle_sections(tree)


def _joint(tree: Any, name: str) -> Any:  # noqa: ANN401 - a tree of dicts, or tomlkit's own
    joints = tree.setdefault("joints", {})
    if isinstance(joints, list):
        return next(joint for joint in joints if joint.get("name") == name)
    return joints.setdefault(name, {})


def _drop_idle_sections(tree: Any) -> None:  # noqa: ANN401 - a tree of dicts, or tomlkit's own
    """Take shared sections out that only links named which have their own now."""
    sections = tree.get("sections", {})
    named: set[str] = set()
    waiting: list[Any] = [tree]
    while waiting:
        inner = waiting.pop()
        for value in inner.values() if isinstance(inner, dict) else inner:
            if isinstance(value, dict | list):
                waiting.append(value)
            elif isinstance(value, str):
                named.add(str(value))
    for name in [name for name in sections if name not in named]:
        sections.pop(name)
    if not sections and "sections" in tree:
        tree.pop("sections")


def _table(values: dict[str, Any], *, plain: bool) -> Any:  # noqa: ANN401 - a dict, or tomlkit's own
    if plain:
        return values
    import tomlkit

    out = tomlkit.inline_table()
    out.update(values)
    return out


def stated_by(part: Part) -> dict[str, Any]:
    """How does a file state this part? Its fields by name, quantities with their unit; lengths in mm."""
    out: dict[str, Any] = {}
    for name in type(part).model_fields:
        value = getattr(part, name)
        quantity = next((mark for mark in inside([type(part)], name) if isinstance(mark, Quantity)), None)
        if name != "kind" and (value is None or name not in part.model_fields_set):
            continue
        if quantity is not None and quantity.si and isinstance(value, float):
            factor, unit = _MM.get(quantity.si, (1.0, quantity.si))
            out[name] = f"{value * factor:.12g} {unit}"
        else:
            out[name] = value
    return out


def reads_back(source: Path, written: Path, found: Sizing) -> str:
    """Is the file that was written the sized arm when it is read again? What is wrong, in a few words; empty where nothing is.

    A file that an arm names (rows of reducers, a table of a compliance) lies in the arm's folder: from another one it is not found.
    """
    from lostmotion.formats import read

    try:
        again = read(written) if source.suffix.lower() == ".toml" else read(source, written)
    except InputError as error:
        return f"it does not read from its folder; put it beside {source.name} ({error.problems[0].key}: {error.problems[0].found})"
    pairs = zip(again.joints, found.sized.joints, strict=True)
    differs = [one.name for one, other in pairs if not math.isclose(one.link.total_mass, other.link.total_mass, rel_tol=1e-9, abs_tol=1e-12)]
    return f"it reads with other links at {', '.join(differs)}" if differs else ""
