"""A first sidecar for a URDF: every joint with its static load, reducers of the catalogue that are rated for it, and what is assumed."""

from __future__ import annotations

import copy
import re
from dataclasses import replace
from typing import TYPE_CHECKING, Any, Final, Literal

import numpy as np

from lostmotion.catalogue.gearboxes import gearboxes
from lostmotion.catalogue.search import Criteria, search, searchable_figures
from lostmotion.errors import InputError
from lostmotion.io.repairs import repair_lines, repairs_in, take_limits
from lostmotion.io.sidecar import find_sidecar, sidecar_place
from lostmotion.io.skeleton import example_parts
from lostmotion.io.toml import key_step, quoted, read_toml
from lostmotion.io.toml_lines import names_lines
from lostmotion.io.urdf import arm_of, tree_of
from lostmotion.io.urdf_chain import find_chain
from lostmotion.io.xacro_file import TABLE as XACRO
from lostmotion.mechanism.even_poses import even_poses
from lostmotion.mechanism.serial import joint_torques

if TYPE_CHECKING:
    from pathlib import Path

    from lostmotion.errors import Problem
    from lostmotion.mechanism.arm import Arm
    from lostmotion.spatial import Floats

# A reducer is proposed where its rated torque is this many times the largest static load: room for acceleration.
_MARGIN: Final = 1.5
# Larger ones are far too heavy for their joint: the catalogue has no reducer of its class.
_MOST_MARGIN: Final = 20.0
_PROPOSED: Final = 3
_RATIO: Final = 100.0
# Joints of arms turn slowly: reducers of less are for machines with large motors.
_LEAST_RATIO: Final = 30.0
_NOTHING: Final = 1e-6
# What `example_parts` calls the joints of each type.
_EXAMPLES: Final[dict[str, Literal["turning", "sliding"]]] = {"revolute": "turning", "prismatic": "sliding"}
_KEYS: Final = {"gearboxes": "gearbox", "bearings": "bearing", "encoders": "encoder"}
_LINK: Final = '{ section = { kind = "tube", outer = "80 mm", wall = "4 mm" }, material = "aluminium", length_tolerance = "0.1 mm" }'


@names_lines
def first_sidecar(path: Path, tip: str | None = None) -> str:
    """Return the text of a sidecar for a URDF, which the reader accepts as it is. Every value in it is marked as assumed.

    `tip` is the link that is the tool. Unless given, an existing sidecar decides on it, as on the base; its repairs of the description are kept.
    Raises InputError with every mistake in the files.
    """
    beside = find_sidecar(path)
    whole = {} if beside is None else read_toml(beside)
    stated = {key: value for key, value in whole.items() if key in ("tip", "base", XACRO)}
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
    q = even_poses(arm)
    held = np.abs(joint_torques(arm, q)).max(axis=0)
    lines = [
        f"# Sidecar of {path.name}: what {tree.format} cannot state. It is found by its name beside that file.",
        "# Everything here is assumed. Replace it by your own parts, and take each key that you know out of the lists `assumed`.",
        f"# Static loads: the largest of {len(q)} poses spread evenly over the joint ranges, without payload; base level.",
        f"# Reducers: the smallest of the catalogue, of ratio {_LEAST_RATIO:g} or more, whose rated torque is at least {_MARGIN} times the static",
        "# load of this joint and of all farther out. That leaves room for acceleration; life and shocks are not checked.",
        f"# None is proposed whose rated torque is more than {_MOST_MARGIN:g} times what is needed.",
        *(f"# Warning: {warning}" for warning in arm.warnings),
        "",
        f"tip = {quoted(tip)}",
        *([f"base = {quoted(stated['base'])}"] if isinstance(stated.get("base"), str) else []),
        *_arguments(stated.get(XACRO, {})),
        "",
        "[payload]",
        'mass = "0 kg"                 # what the arm carries: it decides on sag and wind-up',
        'assumed = ["mass"]',
    ]
    joints = _joints(arm, held, repairs)
    for kind, example in _EXAMPLES.items():
        if any(joint.type == kind for joint in arm.moving):
            for table, part in example_parts(example).items():
                if any(f'{_KEYS[table]} = "{example}_example"' in each for each in joints):
                    lines += part
    return "\n".join([*lines, *joints]) + "\n"


def _of_option(problem: Problem, *, asked: bool) -> Problem:
    """Return a mistake whose remedy is a tip with the option that states it, for there may be no sidecar yet; `asked`: the option was given."""
    stated = re.fullmatch(r'tip = "(?P<link>[^"\\]+)"', problem.example)
    if stated is None:
        return problem
    if asked and problem.key == "tip":
        return replace(problem, file="", example="", passing=(("tip", stated["link"]),))
    return replace(problem, example=f"--tip {stated['link']} (in Python, and in a sidecar: {problem.example})")


def _arguments(stated: dict[str, Any]) -> list[str]:
    """Return the table of the arguments of a xacro file, as stated."""
    lines = [f"{key_step(name)} = {quoted(value) if isinstance(value, str) else str(value).lower()}" for name, value in stated.items()]
    return ["", f"[{XACRO}]", *lines] if lines else []


def _joints(arm: Arm, held: Floats, repairs: dict[str, dict[str, Any]]) -> list[str]:
    lines: list[str] = []
    for k, joint in enumerate(arm.moving):
        turning = joint.type == "revolute"
        example = f"{_EXAMPLES[joint.type]}_example"
        lines += [
            "",
            f"[joints.{key_step(joint.name)}]",
            *repair_lines(repairs.get(joint.name, {})),
            f"# static load: {held[k] if held[k] > _NOTHING else 0:.3g} {joint.load_unit}",
        ]
        needed = _MARGIN * max((held[i] for i in range(k, len(held)) if arm.moving[i].type == "revolute"), default=0.0)
        found = _reducers(needed) if turning and needed > _NOTHING else []
        if found:
            first, *others = found
            lines += [f"gearbox = {quoted(first[0])}   # rated {first[1]:.4g} N m, for {needed:.3g} N m"]
            lines += [f"# gearbox = {quoted(name)}   # rated {rated:.4g} N m" for name, rated in others]
        else:
            lines.append(f'gearbox = "{example}"   # no reducer of the catalogue proposed: values of the class')
        lines += [f'bearing = "{example}"', f'encoder = "{example}"', 'assumed = ["gearbox", "bearing", "encoder"]']
        lines.append(f"# link = {_LINK}")
    return lines


def _reducers(needed: float) -> list[tuple[str, float]]:
    """Return name and rated torque (N m) of the smallest reducers that are rated for this torque and not for far more, one of each model."""
    out: dict[str, tuple[str, float]] = {}
    for row in sorted(search(gearboxes(), Criteria(min_torque=needed)).rows, key=lambda row: searchable_figures(row)["rated torque"]):
        if searchable_figures(row)["rated torque"] > _MOST_MARGIN * needed:
            break
        ratio = _RATIO if row.applies_to(_RATIO) else row.typical_ratio or _RATIO
        if ratio < _LEAST_RATIO:
            continue
        out.setdefault(row.models[0], (f"{row.models[0]}-{ratio:g}", searchable_figures(row)["rated torque"]))
        if len(out) == _PROPOSED:
            break
    return list(out.values())
