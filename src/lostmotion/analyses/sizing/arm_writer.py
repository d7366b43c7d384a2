"""The sized arm as a file: the user's own text with other sections, reducers and clearances in it, comments kept."""

from __future__ import annotations

import copy
import math
import tomllib
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any, Final

from lostmotion.errors import InputError
from lostmotion.io.field_schema import inside
from lostmotion.io.provenance import forget_assumed
from lostmotion.io.text import read_text
from lostmotion.io.toml import MEGABYTES
from lostmotion.units import Quantity

if TYPE_CHECKING:
    from lostmotion.analyses.sizing.sizing import Sizing
    from lostmotion.analyses.sizing.target_study import Aimed
    from lostmotion.parts.error_source import Part
    from lostmotion.parts.joint import Joint
    from lostmotion.parts.section import Plain

# What gives way to a section in a link's table.
_INSTEAD: Final = ("compliance", "measured", "rigid")
_MM: Final = {"m": (1e3, "mm")}


def sized_text(source: str | Path, sidecar: str | Path | None, found: Sizing | Aimed) -> str:
    """Which text describes the sized arm, in the place of the file that the arm was read from, or of the URDF's sidecar?"""
    path = Path(source)
    if path.suffix.lower() != ".toml":
        from lostmotion.io.sidecar import find_sidecar

        return sized_toml(find_sidecar(path) if sidecar is None else Path(sidecar), found)
    return sized_toml(path, found)


def sized_toml(source: Path | None, found: Sizing | Aimed) -> str:
    """Which text describes the sized arm as `source` describes the stated one?

    `source` is the arm's TOML, or the sidecar of a URDF (None where it has none: then the text is a sidecar of its own). Every link that was sized
    states its section in its own table, and a joint names its reducer. A bearing that joints share gets its clearance where all of them have the
    same, else those that differ share a new one. Shared parts that nobody names any more go.
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


@dataclass(frozen=True, slots=True)
class _Change:
    """What is new at one joint: the section of its link, its gearbox as a file states it, its bearing's clearance likewise."""

    joint: str
    section: Plain | None = None
    gearbox: Any = None
    clearance: str | None = None


def _changes(found: Sizing | Aimed) -> list[_Change]:
    bought = getattr(found, "bought", None)
    if bought is None:
        return [_Change(link.joint, link.section) for link in found.links]  # type: ignore[union-attr]
    keys = {"link": "section", "gearbox": "gearbox", "bearing": "clearance"}
    return [
        _Change(each.slot.joint, **{keys[each.slot.what]: each.chosen.part if each.slot.what == "link" else each.chosen.stated})
        for each in bought
        if each.chosen.part is not None
    ]


def _put(tree: Any, found: Sizing | Aimed, *, plain: bool) -> None:  # noqa: ANN401 - a tree of dicts, or tomlkit's own
    stated = {joint.name: joint for joint in found.arm.joints}
    sized = {joint.name: joint for joint in found.sized.joints}
    changes = _changes(found)
    left: dict[str, set[str]] = {"gearboxes": set(), "bearings": set()}
    for each in changes:
        joint = _joint(tree, each.joint)
        before, after = stated[each.joint], sized[each.joint]
        if each.section is not None:
            link = joint.setdefault("link", {})
            for key in _INSTEAD:
                forget_assumed(link, key)
                link.pop(key, None)
            _set(link, "section", _table(stated_by(each.section), plain=plain))
            if after.link.material != before.link.material and after.link.material is not None:
                _set(link, "material", _table(stated_by(after.link.material), plain=plain))
            if after.link.mass is not None:
                _set(link, "mass", f"{after.link.mass:.12g} kg")
        if each.gearbox is not None:
            left["gearboxes"] |= {str(joint["gearbox"])} if isinstance(joint.get("gearbox"), str) else set()
            _set(joint, "gearbox", _table(each.gearbox, plain=plain) if isinstance(each.gearbox, dict) else each.gearbox)
            if after.mass is not None and after.mass != before.mass:
                _set(joint, "mass", f"{after.mass:.12g} kg")
    left["bearings"] = _put_clearances(tree, {each.joint: each.clearance for each in changes if each.clearance is not None}, plain=plain)
    _drop_idle(tree, {"sections": set(tree.get("sections", {})), **left})


def _put_clearances(tree: Any, wanted: dict[str, str], *, plain: bool) -> set[str]:  # noqa: ANN401 - a tree of dicts, or tomlkit's own
    """Put clearances where the bearings of these joints are stated, and give the shared bearings that joints may have left."""
    joints = tree.get("joints", {})
    named = {joint["name"]: joint for joint in joints} if isinstance(joints, list) else joints
    left = set()
    for name, clearance in wanted.items():
        joint = named[name]
        if not isinstance(joint["bearing"], str):
            _set(joint["bearing"], "clearance", clearance)
            continue
        shared = str(joint["bearing"])
        alike = {wanted.get(other) for other, each in named.items() if each.get("bearing") == shared}
        if alike == {clearance}:
            _set(tree["bearings"][shared], "clearance", clearance)
            continue
        left.add(shared)
        own = copy.deepcopy(_plain(tree["bearings"][shared]))
        _set(own, "clearance", clearance)
        known = next((other for other, part in tree["bearings"].items() if _plain(part) == own), None)
        if known is None:
            known = next(each for k in range(2, len(named) + 3) if (each := f"{shared}-{k}") not in tree["bearings"])
            tree["bearings"][known] = own if plain else _section(own)
        joint["bearing"] = str(known)
    return left


def _set(table: Any, key: str, value: Any) -> None:  # noqa: ANN401 - a dict, or tomlkit's own
    """Put a value that was chosen in the place of the stated one: it is no assumption any more."""
    forget_assumed(table, key)
    table[key] = value


def _plain(part: Any) -> dict[str, Any]:  # noqa: ANN401 - a tree of dicts, or tomlkit's own
    unwrapped = part.unwrap() if hasattr(part, "unwrap") else part
    return dict(unwrapped)


def _section(values: dict[str, Any]) -> Any:  # noqa: ANN401 - tomlkit's own
    import tomlkit

    out = tomlkit.table()
    out.update(values)
    out.add(tomlkit.nl())
    return out


def _joint(tree: Any, name: str) -> Any:  # noqa: ANN401 - a tree of dicts, or tomlkit's own
    joints = tree.setdefault("joints", {})
    if isinstance(joints, list):
        return next(joint for joint in joints if joint.get("name") == name)
    return joints.setdefault(name, {})


def _drop_idle(tree: Any, candidates: dict[str, set[str]]) -> None:  # noqa: ANN401 - a tree of dicts, or tomlkit's own
    """Take shared parts out, of those by table, that nobody names now."""
    named: set[str] = set()
    waiting: list[Any] = [tree]
    while waiting:
        inner = waiting.pop()
        for value in inner.values() if isinstance(inner, dict) else inner:
            if isinstance(value, dict | list):
                waiting.append(value)
            elif isinstance(value, str):
                named.add(str(value))
    for table, names in candidates.items():
        stock = tree.get(table, {})
        for name in [name for name in stock if name in names and name not in named]:
            stock.pop(name)
        if not stock and table in tree:
            tree.pop(table)


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
        elif name not in ("assumed", "upper_limits") or value:
            out[name] = list(value) if isinstance(value, tuple) else value
    return out


def reads_back(source: Path, written: Path, found: Sizing | Aimed) -> str:
    """Is the file that was written the sized arm when it is read again? What is wrong, in a few words; empty where nothing is.

    A file that an arm names (rows of reducers, a table of a compliance) lies in the arm's folder: from another one it is not found.
    """
    from lostmotion.io import read

    try:
        again = read(written) if source.suffix.lower() == ".toml" else read(source, written)
    except InputError as error:
        return f"it does not read from its folder; put it beside {source.name} ({error.problems[0].key}: {error.problems[0].found})"
    pairs = zip(again.joints, found.sized.joints, strict=True)
    differs = [one.name for one, other in pairs if not _same(one, other)]
    return f"it reads with other parts at {', '.join(differs)}" if differs else ""


def _same(one: Joint, other: Joint) -> bool:
    """Tell whether two joints weigh the same, and have the same gearbox and bearing."""
    masses = ((one.link.total_mass, other.link.total_mass), (one.total_mass, other.total_mass))
    parts = [(getattr(one, name, None), getattr(other, name, None)) for name in ("gearbox", "bearing")]
    alike = all(a is b is None or (a is not None and b is not None and a.model_dump() == b.model_dump()) for a, b in parts)
    return alike and all(math.isclose(a, b, rel_tol=1e-9, abs_tol=1e-12) for a, b in masses)
