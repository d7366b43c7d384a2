"""A first sidecar for a URDF: the class of its drives, the load of each, and reducers of the
catalogue that are rated for it.
"""

from __future__ import annotations

import copy
import re
from dataclasses import replace
from typing import TYPE_CHECKING, Any, Final

from lostmotion.catalogue.drive_classes import drive_classes
from lostmotion.catalogue.gearboxes import gearboxes
from lostmotion.catalogue.search import Criteria, search, searchable_figures
from lostmotion.errors import InputError
from lostmotion.io.drive_classes import DRIVE, DRIVES, LOAD_KEYS
from lostmotion.io.drive_loads import drive_loads, load_text, remarks_of
from lostmotion.io.project_root import KEY as ROOT
from lostmotion.io.repairs import repair_lines, repairs_in, take_limits
from lostmotion.io.sidecar import find_sidecar, sidecar_place
from lostmotion.io.toml import key_step, quoted, read_toml
from lostmotion.io.toml_lines import names_lines
from lostmotion.io.urdf import arm_of, tree_of
from lostmotion.io.urdf_chain import find_chain
from lostmotion.io.xacro_file import TABLE as XACRO

if TYPE_CHECKING:
    from pathlib import Path

    from lostmotion.errors import Problem
    from lostmotion.io.drive_loads import DriveLoads
    from lostmotion.mechanism.arm import Arm

# A reducer is proposed where its rated torque is this many times the largest static load: room for
# acceleration.
_MARGIN: Final = 1.5
# Larger ones are far too heavy for their joint: the catalogue has no reducer of its class.
_MOST_MARGIN: Final = 20.0
_PROPOSED: Final = 3
_RATIO: Final = 100.0
# Joints of arms turn slowly: reducers of less are for machines with large motors.
_LEAST_RATIO: Final = 30.0
_NOTHING: Final = 1e-6


@names_lines
def first_sidecar(path: Path, tip: str | None = None) -> str:
    """Return the text of a sidecar for a URDF, which the reader accepts as it is. Every value in it
    is marked as assumed.

    `tip` is the link that is the tool. Unless given, an existing sidecar decides on it, as on the
    base; its repairs of the description are kept. Raises InputError with every mistake in the
    files.
    """
    beside = find_sidecar(path)
    whole = {} if beside is None else read_toml(beside)
    stated = {key: value for key, value in whole.items() if key in ("tip", "base", ROOT, XACRO)}
    repairs = repairs_in(whole)
    stated |= {"joints": repairs} if repairs else {}
    asked = tip is not None
    if asked:
        stated["tip"] = tip
    content = copy.deepcopy(stated)
    tree = tree_of(path, beside, content)
    take_limits(tree, content)
    try:
        tip = find_chain(tree, content, str(beside or path), sidecar_place(path).name).tip
    except InputError as error:
        raise InputError([_of_option(problem, asked=asked) for problem in error.problems]) from None
    arm = arm_of(path, beside, copy.deepcopy(stated))
    found = drive_loads(arm, {name: joint.effort for name, joint in tree.joints.items()})
    names, basis = ", ".join(drive_classes()), "without payload" if found.masses else "by the reach"
    lines = [
        (
            f"# Sidecar of {path.name}: what {tree.format} cannot state. It is found by its name "
            "beside that file."
        ),
        (
            "# Everything here is assumed from the class of the drives, by the load that each is "
            "to give: gearbox, bearing, encoder, mounting and link."
        ),
        "# State your own parts beside `drive`: what you state takes precedence.",
        *(f"# {remark[0].upper()}{remark[1:]}." for remark in remarks_of(found)),
        (
            f"# Static loads: the largest of poses spread evenly over the joint ranges, {basis}; "
            "base level."
        ),
        (
            f"# Reducers proposed: the smallest of the catalogue, of ratio {_LEAST_RATIO:g} or "
            f"more, whose rated torque is at least {_MARGIN}"
        ),
        (
            "# times the static load of this joint and of all farther out. That leaves room for "
            "acceleration; life and shocks are not checked."
        ),
        (
            f"# None is proposed whose rated torque is more than {_MOST_MARGIN:g} times what is "
            "needed."
        ),
        *(f"# Warning: {warning}" for warning in arm.warnings),
        "",
        f"tip = {quoted(tip)}",
        *([f"{ROOT} = {quoted(stated[ROOT])}"] if ROOT in stated else []),
        *([f"base = {quoted(stated['base'])}"] if isinstance(stated.get("base"), str) else []),
        *_arguments(stated.get(XACRO, {})),
        "",
        "[presets]",
        f"# The class of all drives; this line changes the whole arm: {names}",
        f"{DRIVES} = {quoted(found.of.name)}",
        "",
        "[payload]",
        'mass = "0 kg"                 # what the arm carries: it decides on sag and wind-up',
        'assumed = ["mass"]',
    ]
    return "\n".join([*lines, *_joints(arm, found, repairs)]) + "\n"


def _of_option(problem: Problem, *, asked: bool) -> Problem:
    """Return a mistake whose remedy is a tip with the option that states it, for there may be no
    sidecar yet; `asked`: the option was given.
    """
    stated = re.fullmatch(r'tip = "(?P<link>[^"\\]+)"', problem.example)
    if stated is None:
        return problem
    if asked and problem.key == "tip":
        return replace(problem, file="", example="", passing=(("tip", stated["link"]),))
    return replace(
        problem, example=f"--tip {stated['link']} (in Python, and in a sidecar: {problem.example})"
    )


def _arguments(stated: dict[str, Any]) -> list[str]:
    """Return the table of the arguments of a xacro file, as stated."""
    lines = [
        f"{key_step(name)} = {quoted(value) if isinstance(value, str) else str(value).lower()}"
        for name, value in stated.items()
    ]
    return ["", f"[{XACRO}]", *lines] if lines else []


def _joints(arm: Arm, loads: DriveLoads, repairs: dict[str, dict[str, Any]]) -> list[str]:
    lines: list[str] = []
    held = list(loads.static.values())
    for k, joint in enumerate(arm.driven):
        turning = joint.type == "revolute"
        effort = loads.efforts.get(joint.name)
        limit = "" if effort is None else f"; effort limit: {load_text(effort, joint.load_unit)}"
        lines += [
            "",
            f"[joints.{key_step(joint.name)}]",
            *repair_lines(repairs.get(joint.name, {})),
        ]
        lines.append(
            f"# static load: {held[k] if held[k] > _NOTHING else 0:.3g} {joint.load_unit}{limit}"
        )
        lines.append(
            f"{DRIVE} = {{ {LOAD_KEYS[joint.type]} = "
            f'"{load_text(loads.loads[joint.name], joint.load_unit)}" }}'
        )
        needed = _MARGIN * max(
            (held[i] for i in range(k, len(held)) if arm.driven[i].type == "revolute"), default=0.0
        )
        proposed = _reducers(needed) if turning and needed > _NOTHING else []
        lines += [
            f"# gearbox = {quoted(name)}   # rated {rated:.4g} N m, for {needed:.3g} N m"
            for name, rated in proposed
        ]
    return lines


def _reducers(needed: float) -> list[tuple[str, float]]:
    """Return name and rated torque (N m) of the smallest reducers that are rated for this torque
    and not for far more, one of each model.
    """
    out: dict[str, tuple[str, float]] = {}
    for row in sorted(
        search(gearboxes(), Criteria(min_torque=needed)).rows,
        key=lambda row: searchable_figures(row)["rated torque"],
    ):
        if searchable_figures(row)["rated torque"] > _MOST_MARGIN * needed:
            break
        ratio = _RATIO if row.applies_to(_RATIO) else row.typical_ratio or _RATIO
        if ratio < _LEAST_RATIO:
            continue
        out.setdefault(
            row.models[0], (f"{row.models[0]}-{ratio:g}", searchable_figures(row)["rated torque"])
        )
        if len(out) == _PROPOSED:
            break
    return list(out.values())
