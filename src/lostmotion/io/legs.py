"""Legs that repeat: one description, and a copy of its joints and closures for each place.

The model of an arm has no legs. A copy NAME of a leg with a joint "hip" has a joint "NAME_hip".
"""

from __future__ import annotations

import copy
from typing import TYPE_CHECKING, Any, Final

from lostmotion.errors import nearest, shown
from lostmotion.mechanism.arm import MOST_JOINTS

if TYPE_CHECKING:
    from lostmotion.io.draft import Draft
    from lostmotion.io.validation_errors import Path

LEGS: Final = "legs"
EXAMPLE: Final = (
    '[[legs]] with joins = "platform.tip", copies = [{ name = "a", place = { xyz = ["1 m", "0 m", '
    '"0 m"] }, end = {} }], and [[legs.joints]]'
)
_KEYS: Final = ("after", "joins", "copies", "joints", "closures")
_OF_COPY: Final = ("name", "place", "end", "after")
_ENDS: Final = ("", ".seat", ".tip")


def expand_legs(draft: Draft) -> None:
    """Replace the legs of a draft by joints and closures, one for each copy.

    Its first joint is attached to `after` (of the copy, of the leg, else the base) at the frame
    `place`; the tip of its last joint meets the place that the leg `joins`, at the frame `end`.
    """
    legs = draft.tree.pop(LEGS, [])
    if not isinstance(legs, list) or not all(isinstance(leg, dict) for leg in legs):
        draft.refuse((LEGS,), shown(legs), "a list of legs", EXAMPLE)
        return
    joints, closures = draft.tree.get("joints", []), draft.tree.get("closures", [])
    if not isinstance(joints, list) or not isinstance(closures, list):
        return
    joints, closures = list(joints), list(closures)
    for number, leg in enumerate(legs):
        _expand(draft, number, leg, joints, closures)
        if len(joints) > MOST_JOINTS:
            break
    if legs:
        draft.tree["joints"], draft.tree["closures"] = joints, closures


def _expand(
    draft: Draft, number: int, leg: dict[str, Any], joints: list[Any], closures: list[Any]
) -> None:
    path: Path = (LEGS, number)
    _refuse_unknown(draft, path, leg, _KEYS)
    for key in ("joints", "copies"):
        stated = leg.get(key)
        if not isinstance(stated, list) or not stated or not all(map(_is_named, stated)):
            expected = f"a list of {key}, each with its name"
            draft.refuse((*path, key), shown(stated), expected, EXAMPLE)
            return
    own: list[dict[str, Any]] = leg["joints"]
    if "origin" in own[0]:
        expected = "`place` of each copy alone: it is the origin of the first joint"
        spot = (*path, "joints", 0, "origin")
        draft.refuse(spot, "an origin of a leg's first joint", expected, EXAMPLE)
    names = [joint["name"] for joint in own]
    for k, each in enumerate(leg["copies"]):
        _refuse_unknown(draft, (*path, "copies", k), each, (*_OF_COPY, *names))
        name = each["name"]
        local = {f"{one}{end}": f"{name}_{one}{end}" for one in names for end in _ENDS}
        made = [merged(joint, each.get(joint["name"], {}), local) for joint in own]
        for joint in made:
            joint["name"] = f"{name}_{joint['name']}"
        made[0]["after"] = each.get("after", leg.get("after", "base"))
        made[0]["origin"] = copy.deepcopy(each.get("place", {}))
        joints += made
        for closure in leg.get("closures", []):
            closures.append(closed := copy.deepcopy(closure))
            if isinstance(closed, dict) and isinstance(closed.get("joins"), list):
                closed["joins"] = [local.get(str(place), place) for place in closed["joins"]]
        if "joins" in leg:
            frames = [{}, copy.deepcopy(each.get("end", {}))]
            closures.append({"joins": [f"{name}_{names[-1]}.tip", leg["joins"]], "frames": frames})


def _refuse_unknown(
    draft: Draft, path: Path, table: dict[str, Any], known: tuple[str, ...]
) -> None:
    strange = [key for key in table if key not in known]
    if strange:
        near = nearest(strange[0], known)
        expected = f"one of {', '.join(known)}"
        draft.refuse((*path, strange[0]), "an unknown key", expected, EXAMPLE, near)


def _is_named(stated: Any) -> bool:  # noqa: ANN401 - whatever a file holds
    return isinstance(stated, dict) and isinstance(stated.get("name"), str)


def merged(
    joint: dict[str, Any],
    changes: Any,  # noqa: ANN401 - whatever a file holds
    local: dict[str, str],
) -> dict[str, Any]:
    """Return a copy of a table with the values that one copy of the leg states, attached to the
    places of that copy.
    """
    out = copy.deepcopy(joint)
    for key, value in changes.items() if isinstance(changes, dict) else ():
        inner = out.get(key)
        if isinstance(inner, dict) and isinstance(value, dict):
            out[key] = merged(inner, value, {})
        else:
            out[key] = copy.deepcopy(value)
    if local and "after" in out:
        out["after"] = local.get(str(out["after"]), out["after"])
    return out
