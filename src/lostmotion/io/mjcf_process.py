"""Compile one MJCF model by the package mujoco: a module of its own process, started by `mjcf`."""

from __future__ import annotations

import re
from pathlib import Path
from typing import Any, Final

import mujoco

from lostmotion.errors import shown
from lostmotion.io.own_process import confine, serve
from lostmotion.io.text import refuse

_BODIES: Final = (
    "body_parentid",
    "body_pos",
    "body_quat",
    "body_ipos",
    "body_mass",
    "body_gravcomp",
    "body_geomnum",
    "body_mocapid",
)
_JOINTS: Final = ("jnt_bodyid", "jnt_pos", "jnt_axis", "jnt_range", "jnt_limited", "jnt_stiffness")
_SITES: Final = ("site_bodyid", "site_pos", "site_quat")
_EQUALITIES: Final = ("eq_obj1id", "eq_obj2id", "eq_active0", "eq_data")
_ARRAYS: Final = (*_BODIES, *_JOINTS, *_SITES, *_EQUALITIES)
_LONGEST_WORDS: Final = 200


def compiled(xml: str, meshes: dict[str, bytes], file: str) -> dict[str, Any]:
    """Return the arrays and the names of a model: angles in rad, lengths in m. Raises InputError,
    which names `file`, in the words of MuJoCo.
    """
    try:
        model = mujoco.MjModel.from_xml_string(xml, meshes)
    except ValueError as error:
        # Its lines are those of the reduced text.
        words = re.sub(r",? ?line -?\d+|, column -?\d+", "", " ".join(str(error).split()))
        refuse(
            file,
            "",
            shown(words, _LONGEST_WORDS)[1:-1],
            "a model that MuJoCo compiles",
            '<joint name="j1" axis="0 0 1" range="-90 90"/>',
        )
    out: dict[str, Any] = {name: getattr(model, name).tolist() for name in _ARRAYS}
    out["jnt_type"] = [_word(mujoco.mjtJoint(number)) for number in model.jnt_type]
    out["eq_type"] = [_word(mujoco.mjtEq(number)) for number in model.eq_type]
    out["eq_objtype"] = [_word(mujoco.mjtObj(number)) for number in model.eq_objtype]
    out["qpos0"] = [float(model.qpos0[at]) for at in model.jnt_qposadr]
    for kind, count in (
        ("body", model.nbody),
        ("joint", model.njnt),
        ("site", model.nsite),
        ("equality", model.neq),
    ):
        out[kind] = [getattr(model, kind)(k).name for k in range(count)]
    return out


def _word(member: Any) -> str:  # noqa: ANN401 - of an enumeration of MuJoCo
    """Return "hinge" for mjJNT_HINGE."""
    return str(member.name).rpartition("_")[2].lower()


def _answer(request: dict[str, Any]) -> dict[str, Any]:
    meshes = {name: Path(path).read_bytes() for name, path in request["meshes"].items()}
    confine([])
    return compiled(request["xml"], meshes, request["file"])


if __name__ == "__main__":
    serve(_answer)
