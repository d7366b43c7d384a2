"""Files of every format, spoiled at random: examples and fragments of the tests with numbers, units, words and lines changed, lost or mixed.

Run by itself, `python -m tests.formats.fuzzed COUNT SEED`, it counts the outcomes and names the slowest files.
"""

from __future__ import annotations

import json
import os
import random
import re
import sys
import time
import traceback
import warnings
from collections import Counter
from collections.abc import Callable  # noqa: TC003 - read by the named tuple
from pathlib import Path
from typing import NamedTuple

import numpy as np

from lostmotion import gear, read, screws, worst_case
from lostmotion.analyses.iso9283.measured_file import read_measured
from lostmotion.analyses.sizing.request import read_request
from lostmotion.error_model.bounds import bounds
from lostmotion.errors import LostmotionError
from lostmotion.io.compliance_csv import read_compliance
from lostmotion.io.own_reducers import read_reducers
from lostmotion.io.part_file import read_bearing, read_gearbox
from lostmotion.io.pose_and_zone_text import read_pose, read_zone
from lostmotion.io.poses import read_poses
from lostmotion.io.sweep_designs import read_sweep
from lostmotion.mechanism.serial import joint_torques
from lostmotion.runs.job import order_of
from tests.io.conftest import JOINT
from tests.runs.conftest import ARM, SWEEP

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
# What stands in the place of a number.
NUMBERS = (
    *("0", "-0", "-1", "1", "2", "0.5", "1e-6", "1e-12", "1e-16", "1e-19", "1e-300", "5e-324", "1e15", "9e14", "1e16", "1e300"),
    *("1.8e308", "1e400", "-1e400", "nan", "inf", "9" * 400, "0." + "0" * 390 + "1", "1e" + "9" * 30, "0x" + "f" * 300, "1_0", "٣"),
    *("1,5", "", " ", "--1", "1e", "true", "2020-01-01", "[1, 2]"),
)
UNITS = (
    "mm",
    "m",
    "µm",
    "km",
    "arcmin",
    "deg",
    "rad",
    "rev",
    "N m",
    "N m/arcmin",
    "N m/rad",
    "kg",
    "g",
    "%",
    "GPa",
    "K",
    "kg/m^3",
    "",
    "quux",
    "m^9",
)
WORDS = (
    *("", " ", "\0", "\x1b[31mred", "\x07", "\u202e", "\ufeff", "\ud7ff", "ä" * 300, "..", "../../etc/passwd", "/dev/zero", "a.b", "a\\nb", "'", '"'),
    *("[[", "]]", "{", "}", "=", "#", "<", ">", "&lt;", "&x;", "<!DOCTYPE x>", "\\ud800", "\\u001b[31m", "±", "(uniform)", "(normal)", "NaN", "null"),
)
WORDS_OF_A_FILE = re.compile(r"[A-Za-z_]{2,30}")
NUMBER = re.compile(r"[-+]?\d+(?:\.\d*)?(?:[eE][-+]?\d+)?")
UNIT = re.compile(r"(?<=\d )[A-Za-zµ°%/]+(?: [a-z/]+)?")
QUOTED = re.compile(r'"[^"\n]*"')
LONGEST = 20.0  # s of the processor, that any file may take


class Format(NamedTuple):
    """A kind of file: the name it gets, sound texts of it, and what reads it and asks for a figure."""

    name: str
    seeds: tuple[str, ...]
    read: Callable[[Path], object]


def finite(values: object) -> None:
    """Refuse a figure that is no number."""
    if not np.isfinite(np.asarray(values, float)).all():
        raise AssertionError("a figure that is not finite")


def study(path: Path, sidecar: Path | None = None) -> object:
    """Read an arm, and ask at three poses how far off it is and what its drives hold."""
    arm = read(path, sidecar)
    low, high = arm.limits.T
    poses = np.stack([low, (low + high) / 2, high])
    matrix = screws(arm, poses)
    finite(bounds(matrix).root_sum_square)
    finite(worst_case(matrix))
    finite(matrix.bias)
    finite(joint_torques(arm, poses))
    str(arm.remarks)
    return arm


def look_at(path: Path) -> object:
    """Read a gearbox; of one by stated figures ask what it does under its rated torque."""
    found = read_gearbox(path)
    if found.part.kind == "generic":
        done = gear(path, gearboxes=2)
        finite([figure.value for section in done.sheet.sections for row in section.rows for figure in row.figures])
    return found


def formats(folder: Path) -> tuple[Format, ...]:
    """Return every format; sound files that others go with are laid into the folder."""

    def texts(*patterns: str, lines: int = 0) -> tuple[str, ...]:
        found = [path.read_text(encoding="utf-8") for pattern in patterns for path in sorted(EXAMPLES.glob(pattern))]
        return tuple("\n".join(text.split("\n")[:lines]) if lines else text for text in found)

    sound, urdf, sidecar = folder / "sound.toml", folder / "sound.urdf", folder / "sound-sidecar.toml"
    sound.write_text(ARM, encoding="utf-8")
    urdf.write_text(texts("ur5e.urdf")[0], encoding="utf-8")
    sidecar.write_text(texts("ur5e.toml")[0], encoding="utf-8")
    arm, example = read(sound), read(EXAMPLES / "z-arm.toml")
    made_with = {"lostmotion": "0", "numpy": "0", "scipy": "0", "numba": "0", "zarr": "0", "numcodecs": "0"}
    run = {"made_with": made_with, "arm": "a.toml", "files": {"a.toml": ARM}, "axes": [{"key": "payload.mass", "values": ["1 kg", "2 kg"]}]}
    run |= {"poses": 64, "sets": 8, "law": "sobol", "given": None, "robots": 20, "visits": 3, "seed": 1, "approach": 0, "block": 4, "parts": ["A"]}
    return (
        Format("arm.toml", (ARM + SWEEP, 'name = "x"\n' + JOINT, *texts("*-*.toml", "paper/*.toml")), study),
        Format("arm.urdf", texts("*.urdf"), lambda path: study(path, sidecar)),
        Format("sidecar.toml", texts("ur5e.toml"), lambda path: study(urdf, path)),
        Format("gearbox.toml", (*texts("gearbox/*.toml"), GEARBOX), look_at),
        Format("bearing.toml", texts("bearing/*.toml"), read_bearing),
        Format("sweep.toml", (SWEEP,), lambda path: read_sweep(sound, None, path)),
        Format("sizing.toml", texts("sizing/z-*.toml"), lambda path: read_request(path, {}, example)),
        Format("reducers.toml", (REDUCERS,), read_reducers),
        Format("poses.csv", (POSES,), lambda path: finite(read_poses(path, arm))),
        Format("measured.csv", texts("measured/z-*.csv", lines=30), read_measured),
        Format("compliance.csv", (COMPLIANCE,), lambda path: finite(read_compliance(path)["matrix"])),
        Format("place.txt", ("A=10deg B=0deg", "B=20 deg A=-1 rad", "3"), lambda path: read_pose(path.read_text("utf-8", "replace"), arm)),
        Format("zone.txt", ("x 0..1 m, z 200..300 mm", "y -0.5 m..0.5 m"), lambda path: read_zone(path.read_text("utf-8", "replace"))),
        Format("run.json", (json.dumps(run, indent=1),), lambda path: order_of(path.read_bytes()).read(0)),
    )


def spoiled(seed: str, others: tuple[str, ...], chance: random.Random) -> bytes:
    """Change a sound text at one to four places."""
    text = seed
    for _ in range(chance.choice((1, 1, 1, 1, 1, 1, 2, 2, 4))):
        text = chance.choice(_CHANGES)(text, others, chance)[:200_000]
    raw = text.encode("utf-8", "surrogatepass")
    if chance.random() < 0.05 and raw:
        at = chance.randrange(len(raw))
        raw = raw[:at] + bytes([chance.randrange(256)]) + raw[at + chance.randrange(2) :]
    return raw


def _put(text: str, pattern: re.Pattern[str], by: str, chance: random.Random) -> str:
    found = list(pattern.finditer(text))
    if not found:
        return text
    match = chance.choice(found)
    return text[: match.start()] + by + text[match.end() :]


def _number(text: str, _: tuple[str, ...], chance: random.Random) -> str:
    return _put(text, NUMBER, chance.choice(NUMBERS), chance)


def _unit(text: str, _: tuple[str, ...], chance: random.Random) -> str:
    return _put(text, UNIT, chance.choice(UNITS), chance)


def _word(text: str, others: tuple[str, ...], chance: random.Random) -> str:
    words = WORDS_OF_A_FILE.findall(chance.choice(others)) or [""]
    return _put(text, WORDS_OF_A_FILE, chance.choice((chance.choice(words), chance.choice(words), chance.choice(WORDS))), chance)


def _value(text: str, others: tuple[str, ...], chance: random.Random) -> str:
    values = QUOTED.findall(chance.choice(others)) or ['""']
    other = chance.choice((chance.choice(values), chance.choice(NUMBERS), '["1 mm", 2]', "{ a = 1 }", "[]", "{}", "false", '"' + "x" * 999 + '"'))
    return _put(text, QUOTED, other, chance)


def _line(text: str, others: tuple[str, ...], chance: random.Random) -> str:
    lines = text.split("\n")
    at = chance.randrange(len(lines))
    how = chance.randrange(5)
    if how == 0:
        del lines[at]
    elif how == 1:
        lines.insert(at, lines[chance.randrange(len(lines))])
    elif how == 2:
        lines[at] = chance.choice(chance.choice(others).split("\n"))
    elif how == 3:
        other = chance.randrange(len(lines))
        lines[at], lines[other] = lines[other], lines[at]
    else:
        lines = lines[:at] + lines[at + chance.randrange(1, 8) :]
    return "\n".join(lines)


def _insert(text: str, _: tuple[str, ...], chance: random.Random) -> str:
    at = chance.randrange(len(text) + 1)
    return text[:at] + chance.choice(WORDS) + text[at + chance.choice((0, 0, 1, 5)) :]


def _cut(text: str, others: tuple[str, ...], chance: random.Random) -> str:
    at = chance.randrange(len(text) + 1)
    other = chance.choice(others)
    return text[:at] + (other[chance.randrange(len(other) + 1) :] if chance.random() < 0.5 else "")


_CHANGES = (_number, _number, _number, _unit, _word, _word, _value, _value, _line, _line, _insert, _cut)


class Outcome(NamedTuple):
    """What became of one file: refused, read, or wrong with what was raised, and the processor seconds it took."""

    format: str
    number: int
    said: str
    seconds: float
    raw: bytes


def outcomes(folder: Path, first: int, last: int, seed: int = 1):
    """Spoil files number `first` to `last`, each by itself reproducible, read each, and return what became of it."""
    kinds = formats(folder)
    left = set(os.listdir(folder))  # noqa: PTH208 - names alone
    others = tuple(text for kind in kinds for text in kind.seeds)
    for number in range(first, last):
        chance = random.Random(f"{seed}.{number}")  # noqa: S311 - no secrets
        kind = kinds[number % len(kinds)]
        raw = spoiled(chance.choice(kind.seeds), others if chance.random() < 0.2 else kind.seeds, chance)
        path = folder / kind.name
        path.write_bytes(raw)
        begin = time.process_time()
        try:
            with warnings.catch_warnings():
                warnings.simplefilter("error")
                kind.read(path)
            said = "read"
        except LostmotionError as error:
            said = "refused" if str(error).isprintable() or _plain(str(error)) else "wrong: control characters in the message: " + ascii(str(error))
        except Exception:  # noqa: BLE001 - whatever else is raised is what is looked for
            said = "wrong: " + traceback.format_exc(limit=-6)
        seconds = time.process_time() - begin
        path.unlink()
        if set(os.listdir(folder)) != left:  # noqa: PTH208 - names alone
            said = "wrong: left files behind"
        yield Outcome(kind.name, number, said, seconds, raw)


def _plain(message: str) -> bool:
    return all(line.isprintable() for line in message.split("\n"))


def main() -> None:
    """Spoil so many files from such a seed, and say what became of them."""
    import tempfile

    count, seed = int(sys.argv[1]), int(sys.argv[2])
    counts: Counter[tuple[str, str]] = Counter()
    slowest: list[tuple[float, str, int]] = []
    wrong: Counter[str] = Counter()
    with tempfile.TemporaryDirectory() as name:
        for found in outcomes(Path(name), 0, count, seed):
            kind = found.said.split(":")[0]
            counts[found.format, kind] += 1
            slowest = sorted([*slowest, (found.seconds, found.format, found.number)], reverse=True)[:5]
            if kind == "wrong":
                wrong[found.said] += 1
                if wrong[found.said] == 1:
                    sys.stdout.write(f"--- {found.format} number {found.number}\n{found.said}\n")
                    sys.stdout.flush()
    for each, number in sorted(counts.items()):
        sys.stdout.write(f"{each[0]:16} {each[1]:8} {number}\n")
    sys.stdout.write(f"slowest: {slowest}\n")


if __name__ == "__main__":
    main()
