"""The kinds of input that are spoiled: sound texts of each, what reads it, and a small study of
what it describes.

Sound texts are examples of the project, fragments of its tests, and the files of `tests/io/corpus`,
in a folder for each kind.
"""

from __future__ import annotations

import io
import json
import os
import re
import shlex
import shutil
import sys
import zlib
from contextlib import redirect_stderr, redirect_stdout
from importlib import import_module
from pathlib import Path
from typing import TYPE_CHECKING, Any, NamedTuple
from unittest.mock import patch

import numpy as np

import lostmotion
from lostmotion import gear, read, screws, worst_case
from lostmotion.error_model.bounds import bounds
from lostmotion.io.calibration_file import read_calibration
from lostmotion.io.compliance_csv import read_compliance
from lostmotion.io.measured.visit_file import read_measured
from lostmotion.io.own_reducers import read_reducers
from lostmotion.io.part_file import read_bearing, read_gearbox
from lostmotion.io.pose_and_zone_text import read_pose, read_zone
from lostmotion.io.poses import read_poses
from lostmotion.io.sizing import read_request
from lostmotion.io.sweep_designs import read_sweep
from lostmotion.mechanism.state import state_of
from lostmotion.runs.job import order_of
from tests.io.conftest import JOINT
from tests.io.consistent import EVERY, consistent, studied_shortly
from tests.runs.conftest import ARM, SWEEP

if TYPE_CHECKING:
    from collections.abc import Callable

EXAMPLES = Path(__file__).parents[2] / "examples"
COMPLIANCE = """compliance, Fx [N], Fy [N], Fz [N], Mx [N m], My [N m], Mz [N m]
x [mm], 2.1e-6, 0, 0, 0, 0, 0
y [mm], 0, 3e-6, 0, 0, 0, 0
z [mm], 0, 0, 3e-6, 0, 0, 0
rx [rad], 0, 0, 0, 1e-5, 0, 0
ry [rad], 0, 0, 0, 0, 1e-5, 0
rz [rad], 0, 0, 0, 0, 0, 1e-5
"""
GEARBOX = """[gearbox]
ratio = 50
rated_torque = "40 N m"
stiffness = "10 N m/arcmin"
backlash = "1 arcmin ± 0.3 arcmin"
hysteresis = "0.2 arcmin"
"""
REDUCERS = """[[reducers]]
models = ["X-10"]
maker = "X"
part = { rated_torque = "50 N m", stiffness = "20 N m/arcmin", backlash = "1 arcmin", hysteresis = "0.3 arcmin" }
source = "measured on 5 pieces, 2024"
"""
POSES = "A [deg],B [deg]\n10,20\n-30,5\n0,0\n"
# Drives and encoders of the joints j1 and j2 of the xacro, MJCF and SDF files of the corpus.
PRESETS = """[joints.j1]
gearbox = { ratio = 100, backlash = "1 arcmin ± 0.3 arcmin", stiffness = "20 N m/arcmin" }
encoder = { zero = "1 arcmin" }
[joints.j2]
gearbox = { ratio = 100, backlash = "1 arcmin ± 0.3 arcmin", stiffness = "20 N m/arcmin" }
encoder = { zero = "1 arcmin" }
"""
NO_NUMBER = re.compile(r"(?i)\b(nan|inf)\b")
CORPUS = Path(__file__).parent / "corpus"
SMALL: dict[str, Any] = {"poses": 16, "robots": 8, "visits": 2, "threads": 1}
# Compiled or expanded by another process, which takes as long as a hundred files of other kinds.
SELDOM = 64
# Words that a spoiled command may not have: it writes nowhere but below the folder, asks no network
# and starts no server.
UNSAFE = ("view", "--dask", "--workers", "--install-completion", "--show-completion")


class Format(NamedTuple):
    """A kind of input: the name of its file, sound texts of it, what reads it and asks for a
    figure, and a small study of what was read.

    every: it is spoiled in one of so many rounds
    """

    name: str
    seeds: tuple[str, ...]
    read: Callable[[Path], object]
    study: Callable[[Path], object] | None = None
    every: int = 1


def finite(values: object) -> None:
    """Refuse a figure that is no number."""
    if not np.isfinite(np.asarray(values, float)).all():
        raise AssertionError("a figure that is not finite")


def sound(found: Any) -> object:
    """Return a result that prints no figure that is no number, which can be written as JSON."""
    sheet = found.sheet
    texts = [
        sheet.verdict,
        *(text for _, text in sheet.brief),
        *(card.number for card in sheet.cards),
    ]
    texts += [
        str(figure) for section in sheet.sections for row in section.rows for figure in row.cells
    ]
    for text in texts:
        assert not NO_NUMBER.search(text), text
    json.dumps(found.result(), allow_nan=False)
    return found


def study(path: Path, sidecar: Path | None = None) -> object:
    """Read an arm, and ask at three poses how far off it is and what its drives hold."""
    arm = read(path, sidecar)
    low, high = arm.limits.T
    poses = np.stack([low, (low + high) / 2, high])
    matrix = screws(state_of(arm, poses))
    finite(bounds(matrix).root_sum_square)
    finite(worst_case(matrix))
    finite(matrix.bias)
    finite(state_of(arm, poses).torques)
    str(arm.remarks)
    return arm


def look_at(path: Path) -> object:
    """Read a gearbox; of one by stated figures ask what it does under its rated torque."""
    found = read_gearbox(path)
    if found.part.kind == "generic":
        sound(gear(path, gearboxes=2))
    return found


def of_arm(path: Path, sidecar: Path | None = None) -> object:
    """Study an arm at a few poses: shortly, but for one in so many."""
    text = path.read_bytes() + (sidecar.read_bytes() if sidecar else b"")
    if zlib.crc32(text) % EVERY:
        return studied_shortly(read(path, sidecar))
    found = lostmotion.study(path, sidecar=sidecar, **SMALL)
    consistent(found.sampled)
    return sound(found)


def command(path: Path) -> object:
    """Carry out a command line in the folder; refused, it leaves nothing behind, and what it writes
    is whole.
    """
    try:
        words = shlex.split(path.read_text("utf-8", "surrogateescape"))
    except ValueError:
        return None
    path.unlink()
    # `..` names the folder above, but between two numbers it is a range
    if not words or any(
        word in UNSAFE or re.search(r"^~|[/\0]|(?<!\d)\.\.|\.\.(?!\d)", word) for word in words
    ):
        return None
    before, here = set(os.listdir(path.parent)), Path.cwd()  # noqa: PTH208 - names alone
    os.chdir(path.parent)
    try:
        with (
            patch.object(sys, "argv", ["lostmotion", *words]),
            redirect_stdout(io.StringIO()) as printed,
            redirect_stderr(io.StringIO()),
        ):
            code, message = import_module("lostmotion.cli.app")._carried_out()
    finally:
        os.chdir(here)
    made = [path.parent / name for name in set(os.listdir(path.parent)) - before]  # noqa: PTH208 - names alone
    left = sorted(str(each.name) for each in made)
    results = [
        json.loads(file.read_bytes(), parse_constant=_no_number)
        for each in made
        for file in each.rglob("result.json")
    ]
    for each in made:
        shutil.rmtree(each) if each.is_dir() else each.unlink()
    assert code in {0, 1, 2}, f"exit code {code}"
    assert code != 2 or not left, f"refused, and left {left}: {message}"
    assert "Traceback" not in printed.getvalue() + message
    if code == 2:
        raise lostmotion.LostmotionError(message)
    return results


def _no_number(text: str) -> None:
    raise AssertionError(f"{text} in result.json")


def in_corpus(name: str) -> tuple[str, ...]:
    """Return the texts of the corpus for a kind of input; of command lines each line is one."""
    texts = [path.read_text(encoding="utf-8") for path in sorted((CORPUS / name).glob("*"))]
    return (
        tuple(line for text in texts for line in text.splitlines())
        if name == "command.txt"
        else tuple(texts)
    )


def formats(folder: Path) -> tuple[Format, ...]:
    """Return every format; sound files that others go with are laid into the folder."""

    def texts(*patterns: str, lines: int = 0) -> tuple[str, ...]:
        found = [
            path.read_text(encoding="utf-8")
            for pattern in patterns
            for path in sorted(EXAMPLES.glob(pattern))
        ]
        return tuple("\n".join(text.split("\n")[:lines]) if lines else text for text in found)

    plain, urdf, sidecar = folder / "sound.toml", folder / "robot.urdf", folder / "robot.toml"
    beside = {
        "sound.toml": ARM.replace(
            'gearbox = "small"', 'gearbox = "small"\nencoder = { zero = "1 arcmin" }'
        ),
        "robot.urdf": texts("ur5e.urdf")[0],
        "robot.toml": texts("ur5e.toml")[0],
        "j.toml": PRESETS,
        "poses.csv": POSES,
        "measured.csv": in_corpus("measured.csv")[-1],
        "gearbox.toml": GEARBOX,
        "z.toml": (EXAMPLES / "z-arm.toml").read_text("utf-8"),
        "bearing.toml": texts("bearing/*.toml")[0],
        "calibration.toml": in_corpus("calibration.toml")[0],
    }
    for name, text in beside.items():
        (folder / name).write_text(text, encoding="utf-8")
    arm, example, presets = read(plain), read(EXAMPLES / "z-arm.toml"), folder / "j.toml"
    made_with = {
        "lostmotion": "0",
        "numpy": "0",
        "scipy": "0",
        "numba": "0",
        "zarr": "0",
        "numcodecs": "0",
    }
    run = {
        "made_with": made_with,
        "arm": "a.toml",
        "files": {"a.toml": ARM},
        "axes": [{"key": "payload.mass", "values": ["1 kg", "2 kg"]}],
    }
    run |= {
        "poses": 64,
        "sets": 8,
        "law": "sobol",
        "given": None,
        "robots": 20,
        "visits": 3,
        "seed": 1,
        "approach": 0,
        "block": 4,
        "parts": ["A"],
    }
    kinds = (
        Format(
            "arm.toml",
            (ARM + SWEEP, 'name = "x"\n' + JOINT, *texts("*-*.toml", "paper/*.toml")),
            study,
            of_arm,
        ),
        Format(
            "arm.urdf",
            texts("*.urdf"),
            lambda path: study(path, sidecar),
            lambda path: of_arm(path, sidecar),
        ),
        Format(
            "sidecar.toml",
            texts("ur5e.toml"),
            lambda path: study(urdf, path),
            lambda path: of_arm(urdf, path),
        ),
        Format(
            "arm.xacro",
            (),
            lambda path: study(path, presets),
            lambda path: of_arm(path, presets),
            SELDOM,
        ),
        Format(
            "arm.xml",
            (),
            lambda path: study(path, presets),
            lambda path: of_arm(path, presets),
            SELDOM,
        ),
        Format(
            "arm.sdf",
            (),
            lambda path: study(path, presets),
            lambda path: of_arm(path, presets),
        ),
        Format(
            "made.gearbox.toml",
            (*texts("gearbox/*.toml"), GEARBOX),
            look_at,
            lambda path: sound(gear(path, gearboxes=2)),
        ),
        Format(
            "made.bearing.toml",
            texts("bearing/*.toml"),
            read_bearing,
            lambda path: sound(lostmotion.bearing(path, bearings=2)),
        ),
        Format("sweep.toml", (SWEEP,), lambda path: read_sweep(plain, None, path)),
        Format(
            "sizing.toml", texts("sizing/z-*.toml"), lambda path: read_request(path, {}, example)
        ),
        Format("reducers.toml", (REDUCERS,), read_reducers),
        Format(
            "made.calibration.toml",
            (),
            lambda path: read_calibration(path, arm),
            lambda path: _calibrated(plain, path),
        ),
        Format(
            "made.poses.csv",
            (POSES,),
            lambda path: finite(read_poses(path, arm)),
            lambda path: sound(lostmotion.study(plain, **{**SMALL, "poses": path})),
        ),
        Format(
            "made.measured.csv",
            texts("measured/z-*.csv", lines=30),
            read_measured,
            lambda path: sound(lostmotion.iso9283(measured=path)),
        ),
        Format(
            "compliance.csv", (COMPLIANCE,), lambda path: finite(read_compliance(path)["matrix"])
        ),
        Format(
            "place.txt",
            ("A=10deg B=0deg", "B=20 deg A=-1 rad", "3"),
            lambda path: read_pose(path.read_text("utf-8", "replace"), arm),
        ),
        Format(
            "zone.txt",
            ("x 0..1 m, z 200..300 mm", "y -0.5 m..0.5 m"),
            lambda path: read_zone(path.read_text("utf-8", "replace")),
        ),
        Format(
            "run.json",
            (json.dumps(run, indent=1),),
            lambda path: order_of(path.read_bytes()).read(0),
        ),
        Format("command.txt", (), command, None, 8),
    )
    return tuple(
        kind._replace(seeds=(*kind.seeds, *in_corpus(kind.name.removeprefix("made."))))
        for kind in kinds
    )


def _calibrated(arm: Path, calibration: Path) -> object:
    """Write the controller of a calibrated arm as C."""
    lostmotion.export_c(arm, out=calibration.parent / "made", calibration=calibration)
    shutil.rmtree(calibration.parent / "made")
    return None
