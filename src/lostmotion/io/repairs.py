"""Repairs of a description by its sidecar: limits of joints, masses and centres of mass of links,
in place of what the description states.

    [joints.elbow]
    limits = ["-150 deg", "150 deg"]
    link = { mass = "2.5 kg", centre_of_mass = ["120 mm", "0 mm", "15 mm"] }

A mass and its centre are those of everything that the joint carries up to the next joint; the
centre is seen from the joint's frame, as in a URDF.
"""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Any, Final

from pydantic import TypeAdapter, ValidationError

from lostmotion.io.limits import listed
from lostmotion.io.toml import quoted
from lostmotion.parts.joint import SlidingLimits, TurningLimits

if TYPE_CHECKING:
    from lostmotion.io.draft import Draft
    from lostmotion.io.urdf_tree import UrdfTree

_RANGES: Final[dict[str, Any]] = {
    "revolute": TurningLimits,
    "continuous": TurningLimits,
    "prismatic": SlidingLimits,
}
# In place of a range that cannot be read: the arm refuses it by its key.
_STAND_IN: Final = (-1.0, 1.0)
# Stands in the note on them.
REPAIRED: Final = "repaired by"
_OF_LINK: Final = {"mass": "mass", "centre_of_mass": "centre of mass"}


def take_limits(tree: UrdfTree, content: dict[str, Any]) -> None:
    """Set the limits that a sidecar states for joints of the description, which decide on the
    joints that move, and so on the chain.
    """
    by_name = content.get("joints")
    for name, parts in by_name.items() if isinstance(by_name, dict) else ():
        joint = tree.joints.get(name)
        if (
            joint is not None
            and joint.type in _RANGES
            and isinstance(parts, dict)
            and "limits" in parts
        ):
            joint.limits = _range(parts["limits"], joint.type)
            joint.limit_mistakes.clear()
            joint.repaired.add("limits")
            joint.type = "prismatic" if joint.type == "prismatic" else "revolute"


def _range(stated: Any, kind: str) -> tuple[float, float]:  # noqa: ANN401 - whatever a file holds
    try:
        low, high = TypeAdapter[tuple[float, float]](_RANGES[kind]).validate_python(
            stated, context={"text": True}
        )
    except ValidationError:
        return _STAND_IN
    return float(low), float(high)


def repairs_in(content: dict[str, Any]) -> dict[str, dict[str, Any]]:
    """Return, by joint, the part of a sidecar's tables of joints that repairs its description."""
    by_name = content.get("joints")
    out: dict[str, dict[str, Any]] = {}
    for name, parts in by_name.items() if isinstance(by_name, dict) else ():
        stated = parts if isinstance(parts, dict) else {}
        link = stated.get("link")
        of_link = (
            {key: link[key] for key in _OF_LINK if key in link} if isinstance(link, dict) else {}
        )
        kept = {
            **({"limits": stated["limits"]} if "limits" in stated else {}),
            **({"link": of_link} if of_link else {}),
        }
        if kept:
            out[name] = kept
    return out


def repair_lines(stated: dict[str, Any]) -> list[str]:
    """Return the lines of one joint's repairs, as they stand in its table."""
    return [f"{key} = {_toml(value)}" for key, value in stated.items()]


def _toml(value: Any) -> str:  # noqa: ANN401 - whatever a file holds
    if isinstance(value, dict):
        return "{ " + ", ".join(f"{key} = {_toml(each)}" for key, each in value.items()) + " }"
    if isinstance(value, list):
        return "[" + ", ".join(map(_toml, value)) + "]"
    return quoted(value) if isinstance(value, str) else str(value).lower()


def note_repairs(draft: Draft, content: dict[str, Any], tree: UrdfTree) -> None:
    """Note what a sidecar states in place of the description, and mark it in the tree, whose doubts
    it may answer.
    """
    by_name = content.get("joints")
    found: dict[str, list[str]] = {"limits": [], **{name: [] for name in _OF_LINK.values()}}
    for name, parts in by_name.items() if isinstance(by_name, dict) else ():
        joint = tree.joints.get(name)
        if joint is None or not isinstance(parts, dict):
            continue
        if "limits" in joint.repaired:
            found["limits"].append(name)
        link = parts.get("link")
        for key, words in _OF_LINK.items():
            if isinstance(link, dict) and key in link:
                joint.repaired.add(key)
                found[words].append(name)
    listing = "; ".join(f"{words} of {listed(names)}" for words, names in found.items() if names)
    if listing:
        draft.note(f"{tree.format} {REPAIRED} {Path(draft.file).name}: {listing}")
