"""Arms, sweeps and sizing from dictionaries of Python: the same answers and the same messages as
from files with that content.
"""

from __future__ import annotations

import copy
import math
import tomllib
from typing import TYPE_CHECKING

import numpy as np
import pytest

import lostmotion
from tests.runs.conftest import ARM

if TYPE_CHECKING:
    from pathlib import Path

TREE = tomllib.loads(ARM)
KEY = "gearboxes.small.backlash"
SWEEP = {
    KEY: ("0.5 arcmin",),
    "payload.mass": {"from": "1 kg", "to": "2 kg", "steps": 2},
}
SIZES = {"poses": 16, "robots": 8, "visits": 2}


def written(folder: Path, text: str, name: str = "tiny.toml") -> Path:
    """Write a file and return its path."""
    path = folder / name
    path.write_text(text, encoding="utf-8")
    return path


def mistakes(of, *given, **named):
    """Return where, found, expected and example of each mistake."""
    with pytest.raises(lostmotion.InputError) as refused:
        of(*given, **named)
    return [(each.key, each.found, each.expected, each.example) for each in refused.value.problems]


def test_an_arm_of_a_dictionary_is_that_of_the_file(tmp_path):
    """Every figure has the same bits; the dictionary is left as it was."""
    before = copy.deepcopy(TREE)
    of_file = lostmotion.study(written(tmp_path, ARM), **SIZES)
    of_dictionary = lostmotion.study(TREE, **SIZES)
    assert of_dictionary.result()["figures"] == of_file.result()["figures"]
    assert before == TREE


def test_tuples_arrays_paths_and_numbers_of_numpy_are_those_of_a_file():
    """A row of joint limits may be a tuple, a number one of NumPy."""
    tree = copy.deepcopy(TREE)
    for joint in tree["joints"]:
        joint["limits"] = tuple(joint["limits"])
        joint["axis"] = np.array([0.0, 0.0, 1.0])
    arm = lostmotion.read(tree)
    assert np.array_equal(arm.limits, lostmotion.read(TREE).limits)
    assert all(joint.axis == (0, 0, 1) for joint in arm.joints)


def test_mistakes_are_those_of_the_file(tmp_path):
    """All at once, each under its key, with the same words; where a file has its name, "arm"."""
    wrong = ARM.replace("backlash =", "baklash =").replace('"-90 deg"', '"-90 mm"')
    assert wrong.count("baklash") == 1
    found = mistakes(lostmotion.study, tomllib.loads(wrong))
    assert len(found) > 1
    assert sorted(found) == sorted(mistakes(lostmotion.study, written(tmp_path, wrong)))
    with pytest.raises(lostmotion.InputError, match=r"^\d mistakes\narm: ") as refused:
        lostmotion.read(tomllib.loads(wrong))
    assert {each.file for each in refused.value.problems} == {"arm"}


def test_what_no_file_can_hold_is_refused_under_its_key():
    """Nothing, a function and a key that is no text are three mistakes of one message."""
    tree = {**copy.deepcopy(TREE), 3: "x", "payload": {"mass": None}, "notes": ["a", print]}
    found = mistakes(lostmotion.read, tree)
    assert {key for key, *_ in found} == {"payload.mass", "notes[1]", ""}
    tree["self"] = tree
    assert "nested too deeply" in mistakes(lostmotion.read, tree)[0][1]
    assert "sidecar" in mistakes(lostmotion.read, TREE, "sidecar.toml")[0][1]


def test_a_sweep_of_dictionaries_is_that_of_files(tmp_path):
    """Arm and table, each as a dictionary or a file: the same designs with the same figures, and a
    folder that continues.
    """
    text = "\n".join(
        [
            "[sweep]",
            f'"{KEY}" = ["0.5 arcmin"]',
            '"payload.mass" = { from = "1 kg", to = "2 kg", steps = 2 }',
        ]
    )
    arm, by = written(tmp_path, ARM), written(tmp_path, text, "by.toml")
    of_files = lostmotion.sweep(arm, by, **SIZES, out=tmp_path / "files")
    for k, (one, other) in enumerate(
        ((arm, SWEEP), ({**TREE, "sweep": SWEEP}, None), (TREE, {"sweep": SWEEP}))
    ):
        found = lostmotion.sweep(one, other, **SIZES, out=tmp_path / f"run-{k}")
        assert found.result()["figures"] == of_files.result()["figures"]
    again = lostmotion.sweep(TREE, {"sweep": SWEEP}, **SIZES, out=tmp_path / "run-2")
    assert again.result()["figures"] == of_files.result()["figures"]


def test_mistakes_in_a_swept_dictionary_are_those_of_the_file(tmp_path):
    """Unknown keys and values that the arm refuses, each under its key."""
    wrong = {"joints.Q.mass": ["1 kg"], "payload.mass": ["1 mm", "2 kg"], KEY: "1 arcmin"}
    text = '[sweep]\n"joints.Q.mass" = ["1 kg"]\n"payload.mass" = ["1 mm", "2 kg"]\n'
    text += f'"{KEY}" = "1 arcmin"\n'
    by = written(tmp_path, text, "by.toml")
    of_file = mistakes(lostmotion.sweep, written(tmp_path, ARM), by)
    assert sorted(mistakes(lostmotion.sweep, TREE, wrong)) == sorted(of_file)
    assert len(of_file) == 3


@pytest.mark.usefixtures("few_samples")
def test_sizing_takes_a_dictionary_as_the_file_or_as_its_table(tmp_path):
    """The lightest tubes are the same; mistakes name `by`."""
    tree = copy.deepcopy(TREE)
    family = {"kind": "tube", "outer": "20 mm .. 120 mm", "wall": "3 mm"}
    asked = {"family": family, "material": "aluminium"}
    text = '[sizing]\nmaterial = "aluminium"\n'
    text += 'family = { kind = "tube", outer = "20 mm .. 120 mm", wall = "3 mm" }\n'
    by = written(tmp_path, text, "by.toml")
    found = [
        lostmotion.size(arm, each, poses=8).result()["figures"]
        for arm, each in (
            (written(tmp_path, ARM), by),
            (tree, asked),
            (tree, {"sizing": asked}),
        )
    ]
    assert found[0] == found[1] == found[2]
    ((key, *_),) = mistakes(lostmotion.size, tree, {"sloppe": "1 arcmin"})
    assert key == "sizing.sloppe"


def test_a_part_by_itself_may_be_a_dictionary():
    """A gearbox with the figures of its maker, as `[gearbox]` of a file has them."""
    made = lostmotion.gear({"gearbox": {"backlash": "2 arcmin", "stiffness": "50 N m/arcmin"}})
    assert made.gearbox.backlash.nominal == pytest.approx(math.radians(2 / 60))
    assert mistakes(lostmotion.gear, {"gearbox": {"backlash": "2 kg"}})[0][0] == "gearbox.backlash"
