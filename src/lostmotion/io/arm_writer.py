"""Writing of the sized arm: the user's own file with new sections, reducers and clearances,
comments preserved.
"""

from __future__ import annotations

import copy
import math
import tomllib
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any, Final, Protocol

from lostmotion.errors import InputError
from lostmotion.io.field_schema import inside
from lostmotion.io.leg_tables import gather_legs, inline, spread_legs
from lostmotion.io.provenance import forget_assumed
from lostmotion.io.text import read_text
from lostmotion.io.toml import MEGABYTES
from lostmotion.units import Quantity

if TYPE_CHECKING:
    from collections.abc import Sequence

    from lostmotion.mechanism.arm import Arm
    from lostmotion.parts.error_source import Part
    from lostmotion.parts.joint import Joint
    from lostmotion.parts.section import Plain

# Keys of a link that its section replaces.
_REPLACED: Final = ("compliance", "measured", "rigid")
_MM: Final = {"m": (1e3, "mm")}


@dataclass(frozen=True, slots=True)
class NewParts:
    """New parts at one joint: section of its link, and the file's values of its gearbox and of its
    bearing clearance.
    """

    joint: str
    section: Plain | None = None
    gearbox: Any = None
    clearance: str | None = None


class SizedArm(Protocol):
    """An arm as stated, and with its new parts."""

    @property
    def arm(self) -> Arm:
        """Return the arm as stated."""

    @property
    def sized(self) -> Arm:
        """Return the arm with its new parts."""

    @property
    def new_parts(self) -> Sequence[NewParts]:
        """Return the new parts, by joint."""


def sized_text(source: str | Path, sidecar: str | Path | None, result: SizedArm) -> str:
    """Return the text of the sized arm, which replaces the arm's file or the URDF's sidecar."""
    path = Path(source)
    if path.suffix.lower() != ".toml":
        from lostmotion.io.sidecar import find_sidecar

        return sized_toml(find_sidecar(path) if sidecar is None else Path(sidecar), result)
    return sized_toml(path, result)


def sized_toml(source: Path | None, result: SizedArm) -> str:
    """Return `source` with the parts of the sized arm.

    `source` is the arm's TOML, or the sidecar of a URDF (None: a new sidecar is written). Every
    sized link states its section in its own table, and a joint names its reducer. A shared bearing
    gets the new clearance where all its joints have the same; else joints that differ share a new
    bearing. Shared parts that are no longer named are removed.
    """
    import tomlkit

    text = read_text(source, MEGABYTES) if source is not None else ""
    plain_tree = tomllib.loads(text)
    _write_changes(plain_tree, result, plain=True)
    try:
        document: Any = tomlkit.parse(text)
        _write_changes(document, result, plain=False)
        out = tomlkit.dumps(document)
        if tomllib.loads(out) == plain_tree:
            return out
    except (ValueError, KeyError, TypeError, AttributeError, tomlkit.exceptions.TOMLKitError):
        pass  # tomlkit cannot change this layout in place: write the same tables without comments
    return tomlkit.dumps(plain_tree)


def _write_changes(tree: Any, result: SizedArm, *, plain: bool) -> None:  # noqa: ANN401 - a tree of dicts, or tomlkit's own
    stated = {joint.name: joint for joint in result.arm.joints}
    sized = {joint.name: joint for joint in result.sized.joints}
    changes = result.new_parts
    named = _joints(tree, [each.joint for each in changes], plain=plain)
    replaced: dict[str, set[str]] = {"gearboxes": set(), "bearings": set()}
    for each in changes:
        joint = named[each.joint]
        before, after = stated[each.joint], sized[each.joint]
        if each.section is not None:
            link = joint.setdefault("link", {})
            for key in _REPLACED:
                forget_assumed(link, key)
                link.pop(key, None)
            _set(link, "section", inline(stated_by(each.section), plain=plain))
            if after.link.material != before.link.material and after.link.material is not None:
                _set(link, "material", inline(stated_by(after.link.material), plain=plain))
            if after.link.mass is not None:
                _set(link, "mass", f"{after.link.mass:.12g} kg")
        if each.gearbox is not None:
            replaced["gearboxes"] |= (
                {str(joint["gearbox"])} if isinstance(joint.get("gearbox"), str) else set()
            )
            _set(joint, "gearbox", inline(each.gearbox, plain=plain))
            if after.mass is not None and after.mass != before.mass:
                _set(joint, "mass", f"{after.mass:.12g} kg")
    replaced["bearings"] = _write_clearances(
        tree,
        named,
        {each.joint: each.clearance for each in changes if each.clearance is not None},
        plain=plain,
    )
    gather_legs(tree, plain=plain)
    _remove_unused(tree, {"sections": set(tree.get("sections", {})), **replaced})


def _write_clearances(
    tree: Any,  # noqa: ANN401 - a tree of dicts, or tomlkit's own
    named: dict[str, Any],
    clearances: dict[str, str],
    *,
    plain: bool,
) -> set[str]:
    """Write clearances into the bearings of these joints, and return the shared bearings that some
    of them no longer use.
    """
    replaced = set()
    for name, clearance in clearances.items():
        joint = named[name]
        if not isinstance(joint["bearing"], str):
            _set(joint["bearing"], "clearance", clearance)
            continue
        shared = str(joint["bearing"])
        common = {
            clearances.get(other) for other, each in named.items() if each.get("bearing") == shared
        }
        if common == {clearance}:
            _set(tree["bearings"][shared], "clearance", clearance)
            continue
        replaced.add(shared)
        own = copy.deepcopy(_plain(tree["bearings"][shared]))
        _set(own, "clearance", clearance)
        known = next(
            (other for other, part in tree["bearings"].items() if _plain(part) == own), None
        )
        if known is None:
            known = next(
                each
                for k in range(2, len(named) + 3)
                if (each := f"{shared}-{k}") not in tree["bearings"]
            )
            tree["bearings"][known] = own if plain else _section(own)
        joint["bearing"] = str(known)
    return replaced


def _set(table: Any, key: str, value: Any) -> None:  # noqa: ANN401 - a dict, or tomlkit's own
    """Set a selected value and remove its mark as assumed."""
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


def _joints(tree: Any, changed: list[str], *, plain: bool) -> dict[str, Any]:  # noqa: ANN401 - a tree of dicts, or tomlkit's own
    """Return the tables of the joints by name: those that change, in legs those of the copies."""
    joints = tree.setdefault("joints", {})
    if isinstance(joints, list):
        out = {joint["name"]: joint for joint in joints}
        return {**out, **spread_legs(tree, set(changed), plain=plain)}
    for name in changed:
        joints.setdefault(name, {})
    return dict(joints)


def _remove_unused(tree: Any, candidates: dict[str, set[str]]) -> None:  # noqa: ANN401 - a tree of dicts, or tomlkit's own
    """Remove those of these shared parts, by table, that are no longer named."""
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


def stated_by(part: Part) -> dict[str, Any]:
    """Return the part as a file states it: fields by name, quantities with their unit, lengths in
    mm.
    """
    out: dict[str, Any] = {}
    for name in type(part).model_fields:
        value = getattr(part, name)
        quantity = next(
            (mark for mark in inside([type(part)], name) if isinstance(mark, Quantity)), None
        )
        if name != "kind" and (value is None or name not in part.model_fields_set):
            continue
        if quantity is not None and quantity.si and isinstance(value, float):
            factor, unit = _MM.get(quantity.si, (1.0, quantity.si))
            out[name] = f"{value * factor:.12g} {unit}"
        elif name not in ("assumed", "upper_limits") or value:
            out[name] = list(value) if isinstance(value, tuple) else value
    return out


def reads_back(source: Path, written: Path, result: SizedArm) -> str:
    """Return how the written file differs from the sized arm when it is read again; empty where it
    does not.

    Files that an arm names (reducers, compliance tables) are in the arm's folder and not found from
    another one.
    """
    from lostmotion.io import read

    try:
        again = read(written) if source.suffix.lower() == ".toml" else read(source, written)
    except InputError as error:
        return (
            f"it cannot be read from its folder; move it beside {source.name} "
            f"({error.problems[0].key}: {error.problems[0].found})"
        )
    pairs = zip(again.joints, result.sized.joints, strict=True)
    differs = [one.name for one, other in pairs if not _same(one, other)]
    return f"it is read with other parts at {', '.join(differs)}" if differs else ""


def _same(one: Joint, other: Joint) -> bool:
    """Return whether two joints have the same masses, gearbox and bearing."""
    masses = ((one.link.total_mass, other.link.total_mass), (one.total_mass, other.total_mass))
    parts = [
        (getattr(one, name, None), getattr(other, name, None)) for name in ("gearbox", "bearing")
    ]
    same = all(
        a is b is None or (a is not None and b is not None and a.model_dump() == b.model_dump())
        for a, b in parts
    )
    return same and all(math.isclose(a, b, rel_tol=1e-9, abs_tol=1e-12) for a, b in masses)
