"""On how many assumed sources an arm or a part rests: what one source says counts once, and stating
more never raises the count.
"""

from __future__ import annotations

import itertools
import re
import tomllib

import pytest

import lostmotion
from lostmotion.error_model.given_values import assumed_count, assumed_in_part, bounded_members
from lostmotion.error_model.provenance import states
from lostmotion.io.part_file import read_gearbox
from tests.io.conftest import EXAMPLES

JOINT = (
    '[[joints]]\nname = "{}"\ntype = "revolute"\naxis = "-y"\nlimits = ["-60 deg", "60 deg"]\n{}\n'
)
FULL = {
    "ratio": "100",
    "rated_torque": '"50 N m"',
    "stiffness": '"8 N m/arcmin"',
    "stiffness_scatter": '"10 %"',
    "backlash": '"1 arcmin ± 0.3 arcmin"',
    "hysteresis": '"0.5 arcmin"',
    "transmission_error": '"1 arcmin"',
    "friction_torque": '"0.5 N m ± 20 %"',
}


def count_of(folder, joints, more=""):
    """Return the states of an arm with these joints."""
    path = folder / "arm.toml"
    path.write_text(f'name = "x"\n{joints}{more}', encoding="utf-8")
    return states(lostmotion.read(path))


def gearbox_of(stated, *, assumed=()):
    """Return the line of a gearbox, some of its values marked as assumed."""
    values = ", ".join(f"{key} = {value}" for key, value in stated.items())
    marks = ", ".join(f'"{key}"' for key in assumed)
    return f"gearbox = {{ {values}, assumed = [{marks}] }}"


def test_values_of_one_source_count_once(tmp_path):
    """All values of one preset, of one material, and of a part that joints share count once each,
    however many there are.
    """
    servo = count_of(
        tmp_path, "".join(JOINT.format(name, 'preset = "hobby servo"') for name in "AB")
    )
    assert len(servo.assumed) > 10
    assert servo.assumed_count == 2  # the preset, and the default friction of its bearing
    link = (
        'link = { length = "300 mm ± 0.1 mm", section = { kind = "tube", outer = "60 mm", wall = '
        '"3 mm" }, material = "aluminium" }'
    )
    assert (
        count_of(tmp_path, "".join(JOINT.format(name, link) for name in "ABC")).assumed_count == 1
    )
    shared = (
        "[gearboxes.g]\n"
        + "\n".join(f"{key} = {value}" for key, value in FULL.items())
        + '\nassumed = ["stiffness", "backlash"]\n'
    )
    assert (
        count_of(
            tmp_path, "".join(JOINT.format(name, 'gearbox = "g"') for name in "ABC"), shared
        ).assumed_count
        == 1
    )
    own = "".join(
        JOINT.format(name, gearbox_of({**FULL, "ratio": ratio}, assumed=["stiffness"]))
        for name, ratio in zip("ABC", "123", strict=True)
    )
    assert count_of(tmp_path, own).assumed_count == 3


def test_limits_of_one_catalogue_row_count_once(tmp_path):
    """A maker's limits for a size are one source, whichever of its values they are and however many
    joints have it.
    """
    row = 'gearbox = { catalogue = "RV-42N", ratio = 126, friction_torque = "1 N m ± 20 %" }'
    known = count_of(tmp_path, "".join(JOINT.format(name, row) for name in "AB"))
    assert len(known.assumed) > 1
    assert known.assumed_count == 1


@pytest.mark.parametrize("order", [list(FULL), list(reversed(FULL))], ids=["in order", "reversed"])
def test_stating_a_value_never_raises_the_count_of_what_is_assumed_or_missing(tmp_path, order):
    """One value of a gearbox after another is stated: what it rests on and what is missing of it
    together never become more.
    """
    counts = []
    for k in range(1, len(order) + 1):
        stated = {"ratio": "100", **{key: FULL[key] for key in order[:k]}}
        known = count_of(tmp_path, JOINT.format("A", gearbox_of(stated)))
        counts.append(known.assumed_count + len(known.missing["A"]))
    assert all(after <= before for before, after in itertools.pairwise(counts))
    assert known.assumed_count == 0


@pytest.mark.parametrize("order", [list(FULL), list(reversed(FULL))], ids=["in order", "reversed"])
def test_taking_marks_away_never_raises_the_count(tmp_path, order):
    """The fewer values are marked as assumed, the fewer sources there are, down to none."""
    counts = [
        count_of(tmp_path, JOINT.format("A", gearbox_of(FULL, assumed=order[k:]))).assumed_count
        for k in range(len(order) + 1)
    ]
    assert counts == [1] * len(order) + [0]


@pytest.mark.parametrize("file", ["printed.toml", "rv-like.toml", "two-stage-lobes.toml"])
def test_a_drawing_that_states_more_rests_on_no_more(tmp_path, file):
    """Of a drawn gearbox each key is omitted that can be: what its drawing leaves open then counts,
    bounded members among it, so none is fewer.
    """
    text = re.sub(
        r"(?ms)^assumed = \[.*?^\]$|^assumed = \[.*?\]$",
        "",
        (EXAMPLES / "gearbox" / file).read_text(encoding="utf-8"),
    )
    path = tmp_path / "gearbox.toml"
    tried = 0
    raw = tomllib.loads(text)["gearbox"]
    # without a stage it is another gearbox
    for key in ("", *(key for key in raw if key != "first_stage")):
        path.write_text(_without(text, key), encoding="utf-8")
        try:
            found = read_gearbox(path).part
        except lostmotion.InputError:
            continue  # a dimension that no drawing may lack
        count = assumed_count(assumed_in_part(found, "gearbox"), bounded_members(found))
        if not key:
            full = count
        tried += 1
        assert count >= full, key
    assert tried > 3


def _without(text, key):
    """Return the text of a part file without one key or table of its gearbox."""
    out, skipping = [], False
    for line in text.splitlines():
        head = line.strip()
        if head.startswith("["):
            skipping = bool(key) and head.startswith((f"[gearbox.{key}]", f"[gearbox.{key}."))
        if not skipping and not (key and head.startswith(f"{key} =")):
            out.append(line)
    return "\n".join(out)
