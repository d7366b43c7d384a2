"""One part by itself, a gearbox or a bearing: from a file about that part alone, or from an arm
file and the name of a joint.

name = "shoulder"               # the file's name unless stated
[gearbox]                       # or [bearing], with the keys that a joint's has; or gearbox =
                                "RV-40E-121"
kind = "catalogue"              # a bearing's kind may also be "ball bearing" or "roller bearing",
                                one by itself without span

[materials.onyx]                # what disc_material and ring_material of a drawing name, besides
                                the catalogue's
young = "1.4 GPa"
"""

from __future__ import annotations

import copy
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any, Final, Generic, Literal, TypeVar

from lostmotion.catalogue.gearbox_row import FROM_CATALOGUE
from lostmotion.errors import InputError, Problem, refuse_argument, shown
from lostmotion.io import READERS, read
from lostmotion.io.arm_builder import build_arm
from lostmotion.io.draft import Draft
from lostmotion.io.limits import cut, listed, nearest
from lostmotion.io.own_reducers import OWN_EXAMPLES
from lostmotion.io.reducers import KEY as CATALOGUE
from lostmotion.io.text import begins_as_xml, refuse
from lostmotion.io.toml import source_of
from lostmotion.io.toml_lines import names_lines
from lostmotion.mechanism.arm import LONGEST_NAME
from lostmotion.parts.bearing.rolling_contact import is_drawn_bearing
from lostmotion.parts.bearing.single import OF_PAIRS, PAIRS, single
from lostmotion.parts.gearbox.kinds import is_drawn
from lostmotion.parts.joint import FixedJoint
from lostmotion.parts.provenance import value_keys

if TYPE_CHECKING:
    from lostmotion.mechanism.arm import Arm
    from lostmotion.parts.error_source import ErrorSource
    from lostmotion.parts.moving_joint import Bearing

Kind = Literal["gearbox", "bearing"]
P = TypeVar("P")

_COMMANDS: Final[dict[str, str]] = {"gearbox": "gear", "bearing": "bearing"}
_EXAMPLES: Final[dict[str, str]] = {
    "gearbox": 'gearbox = "RV-40E-121"',
    "bearing": '[bearing] with kind = "rolling", span = "50 mm"',
}
_MATERIALS: Final = "materials"
# The joint that a part alone is checked on: one that turns, or for a part in lengths and forces one
# that slides.
_JOINTS: Final = (
    {"type": "revolute", "limits": ["-90 deg", "90 deg"]},
    {"type": "prismatic", "limits": ["0 mm", "1 mm"]},
)


@dataclass(frozen=True, slots=True)
class OnePart(Generic[P]):
    """A part read by itself: what it is called, where it was described, and what the reader should
    be warned of.
    """

    name: str
    part: P
    notes: tuple[str, ...]


@names_lines
def read_gearbox(
    path: str | Path | Mapping[str, Any], joint: str | None = None
) -> OnePart[ErrorSource]:
    """Return the gearbox that a file describes. A TOML with `gearbox`, or an arm file and the joint
    whose gearbox is meant.

    Names of the catalogue work as in an arm. Raises InputError with every mistake in the file, and
    for an arm without `joint` with its joints' names.
    """
    return _read(path if isinstance(path, Mapping) else Path(path), joint, "gearbox")


@names_lines
def read_bearing(
    path: str | Path | Mapping[str, Any], joint: str | None = None
) -> OnePart[Bearing]:
    """Return the bearing that a file describes. A TOML with `[bearing]`, or an arm file and the
    joint that has it. Errors as `read_gearbox`.
    """
    return _read(path if isinstance(path, Mapping) else Path(path), joint, "bearing")


def _read(path: Path | Mapping[str, Any], joint: str | None, kind: Kind) -> OnePart[Any]:
    if isinstance(path, Path) and path.suffix.lower() != ".toml":
        if READERS.get(path.suffix.lower()) is None and not begins_as_xml(path):
            refuse(
                str(path),
                "",
                f"the ending '{path.suffix}'" if path.suffix else "no ending",
                "a .toml, or an arm file",
                f"{path.stem or 'part'}.toml",
            )
        return _of_joint(read(path), str(path), joint, kind)
    file, tree = source_of("part", path)
    if "joints" in tree:
        return _of_joint(read(path), file, joint, kind)
    if joint is not None:
        expected = (
            "an arm file where a joint is named; this one has no "
            f"joints{', but one ' + kind + ' for itself' if kind in tree else ''}"
        )
        raise refuse_argument("joint", joint, f"{expected}: {Path(file).name}")
    return _alone(file, Path(file).stem, tree, kind)


def _of_joint(arm: Arm, file: str, joint: str | None, kind: Kind) -> OnePart[Any]:
    """Take the part of one joint out of a whole arm."""
    having = [each.name for each in arm.moving if getattr(each, kind) is not None]
    names = (
        f"one of its joints with a {kind}: {listed(having)}"
        if having
        else f"an arm with a {kind} on one of its joints; this one has none"
    )
    example = {"joint": having[0]} if having else {}
    if joint is None:
        raise refuse_argument(
            "joint", f"none named, and {Path(file).name} is an arm", names, **example
        )
    found = next((each for each in arm.joints if each.name == joint), None)
    if found is None:
        problem = Problem(
            "",
            "joint",
            shown(joint),
            names,
            nearest=nearest(joint, having),
            passing=tuple(example.items()),
        )
        raise InputError([problem])
    part = None if isinstance(found, FixedJoint) else getattr(found, kind)
    if part is None:
        raise refuse_argument("joint", f"'{joint}', which has no {kind}", names, **example)
    if kind in found.assumed:  # the joint says that all of it is assumed
        part = part.model_copy(
            update={
                "assumed": tuple(
                    key for key in value_keys(type(part)) if key in part.model_fields_set
                )
            }
        )
    if is_drawn_bearing(part) or is_drawn(part):
        part = part.warmed(arm.environment.rise)
    return OnePart(
        cut(f"{arm.name}, {kind} of joint {joint}", LONGEST_NAME), part, _notes_on(arm, part)
    )


def _notes_on(arm: Arm, part: object) -> tuple[str, ...]:
    """Return the notes of an arm without those on catalogue rows that only parts of other joints
    are from.
    """
    others = {getattr(each.gearbox, "model", "") for each in arm.driven} - {
        getattr(part, "model", "")
    }
    return tuple(
        note
        for note in arm.notes
        if not any(note.startswith(model + FROM_CATALOGUE) for model in others)
    )


def _alone(file: str, stem: str, tree: dict[str, Any], kind: Kind) -> OnePart[Any]:
    """Check a part as if a joint carried it; the keys in the mistakes are those of the file."""
    if kind not in tree:
        other = "bearing" if kind == "gearbox" else "gearbox"
        found = (
            f"a {other}; 'lostmotion {_COMMANDS[other]}' reads it"
            if other in tree
            else f"no {kind}, and no joints"
        )
        refuse(file, kind, found, f"a {kind} by itself, or an arm with joints", _EXAMPLES[kind])
    alone = (
        kind == "bearing" and isinstance(tree[kind], dict) and tree[kind].get("kind") in list(PAIRS)
    )
    refusals = []
    for joint in _JOINTS:
        draft = _draft(file, stem, copy.deepcopy(tree), kind, dict(joint), alone=alone)
        try:
            arm = build_arm(draft)
        except InputError as error:
            refusals.append(error)
        else:
            part = getattr(arm.joints[0], kind)
            return OnePart(arm.name, single(part) if alone else part, arm.notes)
    # A part of a sliding joint is refused as such: a turning joint does not know its kind, or finds
    # more mistakes.
    of_kind = [
        refusal
        for refusal in refusals
        if all(problem.key != f"{kind}.kind" for problem in refusal.problems)
    ]
    raise min(of_kind or refusals, key=lambda refusal: len(refusal.problems))


def _draft(
    file: str, stem: str, tree: dict[str, Any], kind: Kind, joint: dict[str, Any], *, alone: bool
) -> Draft:
    stated = tree.pop(kind)
    unfit = [key for key in OF_PAIRS if key in stated] if alone else []
    if alone:
        # checked as one of two, whose distance decides on nothing that is shown
        stated |= {"kind": PAIRS[stated["kind"]], "span": "1 m"}
    if isinstance(stated, str) and kind == "gearbox":
        stated = {CATALOGUE: stated}
    arm: dict[str, Any] = {
        "name": cut(stem, LONGEST_NAME) or kind,
        "joints": [{"name": "part", **joint, kind: stated}],
    }
    also = {**OWN_EXAMPLES, **({_MATERIALS: "[materials.onyx]"} if kind == "gearbox" else {})}
    arm |= {key: tree.pop(key) for key in ("name", "notes", *also) if key in tree}
    draft = Draft(file, arm, {}, {("joints", 0): "", ("joints", 0, kind): kind})
    for key in unfit:
        draft.refuse(
            ("joints", 0, kind, key),
            f"{key} of a single bearing",
            f"no {key}, or two bearings",
            'kind = "ball pair"',
        )
        stated.pop(key, None)
    if not isinstance(stated, dict):
        draft.refuse(
            ("joints", 0, kind),
            shown(stated),
            f"a table that describes the {kind}",
            _EXAMPLES[kind],
        )
        arm["joints"][0].pop(kind)
    for key, value in tree.items():
        examples = {
            "name": 'name = "shoulder"',
            "notes": 'notes = ["assumed"]',
            kind: _EXAMPLES[kind],
            **also,
        }
        near = nearest(key, examples)
        draft.refuse(
            (key,),
            f"an unknown key with {shown(value)}",
            f"one of {', '.join(examples)}",
            examples[near or kind],
            near,
        )
    return draft
