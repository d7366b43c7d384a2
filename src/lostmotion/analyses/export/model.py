"""The model of an arm for its controller: in Python, and as the files of a C export, which are the
core, the tables of one arm, and what builds and explains them.
"""

from __future__ import annotations

import hashlib
from typing import TYPE_CHECKING, Final

import numpy as np

from lostmotion.analyses.arguments import arm_of
from lostmotion.analyses.quantities import amount
from lostmotion.blas_threads import one_blas_thread
from lostmotion.controller_model.c_source import packaged, table_source, tested_poses, vector_source
from lostmotion.controller_model.controller import Controller
from lostmotion.controller_model.lowering import tables_of
from lostmotion.controller_model.remainder import remainders
from lostmotion.controller_model.scratch_sizes import bytes_of, sizes_of
from lostmotion.controller_model.unrolled import unrolled_source
from lostmotion.controller_model.validity import validity_of
from lostmotion.error_model.provenance import refuse_undescribed, states
from lostmotion.errors import legible
from lostmotion.reporting.provenance import missing_clause
from lostmotion.reporting.sheet import several
from lostmotion.reporting.warnings import arm_warnings
from lostmotion.units import Quantity
from lostmotion.version import __version__

if TYPE_CHECKING:
    from collections.abc import Sequence
    from pathlib import Path

    from lostmotion.controller_model.remainder import Remainder
    from lostmotion.mechanism.arm import Arm
    from lostmotion.mechanism.calibration import Calibration

# Files that are the same for every arm, and where they go.
_FIXED: Final = {
    "lm_core.c": "src/lm_core.c",
    "lm_core.h": "src/lm_core.h",
    "lm_tables.h": "src/lm_tables.h",
    "lm_flat.c": "src/lm_flat.c",
    "lm_flat.h": "src/lm_flat.h",
    "CMakeLists.txt": "CMakeLists.txt",
    "self_test.c": "test/self_test.c",
    "predict.ino": "examples/predict/predict.ino",
}
# How the README describes the two forms of the prediction.
_LOOPED: Final = (
    "The prediction runs over tables, in the same code for every arm. `lostmotion export c "
    "--unroll` writes it out for this arm instead: two to "
    "three times as fast, with three times as much code."
)
_UNROLLED: Final = (
    "The prediction is written out for this arm in `src/lm_unrolled.h`. `-DLM_LOOPED` evaluates "
    "the tables in loops instead: slower, with less code."
)
_MARKS: Final = frozenset("\\`*[]<>|~!&#$")
# Poses of the self test, and those at which the effect of compensation is measured.
_VECTORS: Final = 10
_POSES: Final = 512
# Smaller shares are not written out.
_LEAST_SHARE: Final = 1e-5


def controller(
    arm: Arm | str | Path,
    *,
    largest_payload: float | str | None = None,
    calibration: Calibration | str | Path | None = None,
    accurate_length: bool = False,
) -> Controller:
    """Return the controller of an arm: `predict` and `compensate` on tables, with the formulas of
    the C sources.

    Parameters
    ----------
    arm
        An arm, or its file.
    largest_payload
        Largest payload, in kg or as text with a unit, for which it answers. Default: twice the
        payload of the file, or the mass of the arm where none is stated.
    calibration
        Estimates of the errors of one robot, or their file. Default: none.
    accurate_length
        Whether the 95th percentile of the length is computed within 0.2 % instead of 1.5 %, which
        takes longer.

    Raises
    ------
    InputError
        With every mistake in the files, for a payload that is not positive, for an arm without any
        error source, and for a calibration of draws that the arm does not have.

    """
    described = arm_of("arm", arm, {"calibration": calibration})
    refuse_undescribed(described)
    payload = (
        None
        if largest_payload is None
        else amount("largest_payload", largest_payload, Quantity("kg", "10 kg", above=0))
    )
    with one_blas_thread():
        tables = tables_of(described, validity_of(described, payload))
    return Controller(tables, accurate_length=accurate_length)


def remarks_on(arm: Arm) -> list[str]:
    """Return what a user must know: for which robot it is, overloaded drives, doubtful data, joints
    taken as perfect, assumed values.
    """
    known = states(arm)
    missing, count = missing_clause(known), known.assumed_count
    assumed = (
        f"this rests on {several(count, 'assumed value')}; `lostmotion study` lists them"
        if count
        else ""
    )
    estimates = 0 if arm.calibration is None else len(arm.calibration.streams)
    own = (
        (
            f"this is the model of one calibrated robot, with {several(estimates, 'estimate')} of "
            "its errors: not for another one"
        )
        if estimates
        else ""
    )
    return [
        each
        for each in (
            own,
            *arm_warnings(arm),
            f"{missing}: errors are at least these" if missing else "",
            assumed,
        )
        if each
    ]


def c_files(
    model: Controller,
    arm: Arm,
    remarks: Sequence[str],
    sha256: str,
    *,
    single: bool,
    unroll: bool = False,
) -> dict[str, str]:
    """Return the texts of all files by their path within the folder; with `single` for numbers of
    single precision.

    README.md lists the remarks; sha256 is the hash of the input.
    """
    out = {path: packaged(name) for name, path in _FIXED.items()}
    tables = table_source(model.tables)
    head = _head(model, sha256)
    out["src/lm_model.h"] = _header(model, head, single=single, unroll=unroll)
    if unroll:
        out["src/lm_unrolled.h"] = unrolled_source(model.tables, __version__)
    out["src/lm_model.c"] = (
        f'{head}\n#include "lm_tables.h"\n\n#define R(x) ((lm_real)(x))\n\n'
        f"{_joint_names(model)}\n\n{tables}\n\n{vector_source(model, _VECTORS)}\n"
    )
    out["library.properties"] = packaged("library.properties").format(
        version=__version__, name=_plain(model.tables.name)
    )
    out["lm_simulink.m"] = _simulink(model)
    out["README.md"] = _readme(model, arm, tables, remarks, sha256, single=single, unroll=unroll)
    return out


def _simulink(model: Controller) -> str:
    """Return the script for MATLAB that puts the functions with flat arrays into a model."""
    tables, joints = model.tables, len(model.tables.joints)
    load, gravity = (
        "[" + " ".join(repr(x) for x in each.tolist()) + "]"
        for each in (tables.load, tables.gravity)
    )
    return packaged("lm_simulink.m").format(
        version=__version__,
        name=_plain(tables.name),
        names=", ".join(_plain(name) for name in tables.joints),
        joints=joints,
        load=load,
        gravity=gravity,
        prediction=34 + 8 * joints,
        command=7 + joints,
    )


def _plain(text: str) -> str:
    """Return a text in ASCII that neither begins nor ends a comment."""
    return (
        "".join(each if each.isascii() and each.isprintable() else "_" for each in text)
        .replace("*/", "* /")
        .replace("/*", "/ *")
    )


def markdown(text: str, but: str = "") -> str:
    """Return a text that Markdown shows as it stands on one line: no link, picture, HTML or cell of
    a table begins in it; `but` keeps its meaning.
    """
    line = " ".join(legible(text).split())
    shown = "".join(f"\\{each}" if each in _MARKS and each not in but else each for each in line)
    # A colon before slashes makes an address; an underscore has no meaning within a word.
    return "".join(
        f"\\{each}" if each == "_" and not _within_word(shown, k) else each
        for k, each in enumerate(shown)
    ).replace("://", "\\://")


def bulleted(remarks: Sequence[str]) -> str:
    """Return remarks as a list in Markdown."""
    return "\n".join(f"- {markdown(each, but='`')}" for each in remarks) or "- nothing"


def _within_word(text: str, at: int) -> bool:
    return 0 < at < len(text) - 1 and text[at - 1].isalnum() and text[at + 1].isalnum()


def _head(model: Controller, sha256: str) -> str:
    valid = model.tables.valid
    lines = [
        (
            f"Error model of the arm '{_plain(model.tables.name)}', generated by lostmotion "
            f"{__version__}; do not edit."
        ),
        f"SHA-256 of the input: {sha256}",
        "",
        (
            "Units: rad, m, N, N m, kg, m/s^2. Pose, screws, covariance and gravity are in the "
            "axes of the base; the load is in those of the tool."
        ),
        f"Joints: {', '.join(_plain(name) for name in model.tables.joints)}",
        (
            f"Valid for a payload up to {valid.payload:.4g} kg with its centre within "
            f"{valid.reach:.4g} m of the tool point along each axis, a process"
        ),
        (
            f"force up to {valid.force:.4g} N and moment up to {valid.moment:.4g} N m, and an "
            f"acceleration up to {valid.gravity:.4g} m/s^2, each along"
        ),
        "every axis.",
        (
            "Error of the tables against the study: rounding. Error of the 95th percentile: 1.5 % "
            "of it, for normal errors."
        ),
    ]
    return "/* " + "\n * ".join(lines) + "\n */"


def _joint_names(model: Controller) -> str:
    """Return the names of the joints as C text: other characters than letters, digits and blanks as
    octal numbers of their UTF-8 bytes.
    """
    texts = [
        '"'
        + "".join(
            each if each.isascii() and (each.isalnum() or each in " _.-") else _octal(each)
            for each in name
        )
        + '"'
        for name in model.tables.joints
    ]
    return f"const char *const lm_joint_names[LM_JOINTS] = {{{', '.join(texts)}}};"


def _octal(character: str) -> str:
    return "".join(f"\\{byte:03o}" for byte in character.encode())


def _header(model: Controller, head: str, *, single: bool, unroll: bool) -> str:
    sizes = sizes_of(model.tables)
    defines = {
        "JOINTS": len(model.tables.joints),
        "PLACES": sizes.places,
        "FACTORS": sizes.factors,
        "SIZES": sizes.sizes,
        "SEATS": sizes.seats,
        "TABLES": sizes.tables,
        "FED_FORWARD": int(model.tables.fed_forward),
        "DRAWS": sizes.draws,
        "VECTORS": _VECTORS,
    }
    choice = [
        "",
        "#ifndef LM_LOOPED",
        (
            "#define LM_UNROLLED /* the prediction of lm_unrolled.h; -DLM_LOOPED for that of "
            "lm_core.c */"
        ),
        "#endif",
    ]
    choice = choice if unroll else []
    lines = [f"#define LM_{name} {value}" for name, value in defines.items()]
    precision = (
        [
            "",
            "#if !defined(LM_DOUBLE) && !defined(LM_FLOAT)",
            "#define LM_FLOAT /* single precision; -DLM_DOUBLE for double */",
            "#endif",
        ]
        if single
        else []
    )
    return "\n".join(
        [
            head,
            "#ifndef LM_MODEL_H",
            "#define LM_MODEL_H",
            "",
            *lines,
            *choice,
            *precision,
            "",
            "#endif",
            "",
        ]
    )


def _readme(
    model: Controller,
    arm: Arm,
    tables: str,
    remarks: Sequence[str],
    sha256: str,
    *,
    single: bool,
    unroll: bool,
) -> str:
    """Return the README of this model."""
    valid, limits = model.tables.valid, model.tables.limits
    rows = [
        f"| {k} | {markdown(joint)} | {low:.6g} | {high:.6g} |"
        for k, (joint, (low, high)) in enumerate(zip(model.tables.joints, limits, strict=True))
    ]
    size = 4 if single else 8
    taken, q = bytes_of(model.tables, size), tested_poses(model.tables, _POSES)
    found = remainders(model, arm, q)
    return packaged("README.md").format(
        name=markdown(model.tables.name),
        version=__version__,
        hash=sha256,
        precision="float" if single else "double",
        form=_UNROLLED if unroll else _LOOPED,
        remarks=bulleted(remarks),
        joints="\n".join(rows),
        payload=f"{valid.payload:.4g}",
        reach=f"{valid.reach:.4g}",
        force=f"{valid.force:.4g}",
        moment=f"{valid.moment:.4g}",
        gravity=f"{valid.gravity:.4g}",
        poses=_POSES,
        regular=found[0].poses,
        left="\n".join(
            f"| {passes} | {_left(each)} |" for passes, each in enumerate(found, start=1)
        ),
        vectors=_VECTORS,
        agrees="1e-4" if single else "1e-9",
        table_bytes=f"{size * tables.count('R('):,}".replace(",", " "),
        input_bytes=taken.input,
        output_bytes=taken.output,
        command_bytes=taken.command,
        stack_bytes=f"{taken.stack:,}".replace(",", " "),
    )


def _left(left_over: Remainder) -> str:
    """Return the shares that remain as cells of a table."""
    shares = (left_over.median, left_over.percentile95, left_over.worst)
    return (
        " | ".join(
            f"{100 * share:.2g} %" if share >= _LEAST_SHARE else "below 0.001 %" for share in shares
        )
        if left_over.poses
        else "none | none | none"
    )


def input_hash(arm: Arm) -> str:
    """Return the SHA-256 hash of everything that describes the arm, without the way in which a file
    spells it, and of the estimates of its errors.
    """
    found = hashlib.sha256(repr(arm.model_dump()).encode())
    if (calibration := arm.calibration) is not None:
        found.update(repr(calibration.streams).encode())
        for values in (calibration.mean, calibration.covariance):
            found.update(np.asarray(values, dtype=float).tobytes())
    return found.hexdigest()
