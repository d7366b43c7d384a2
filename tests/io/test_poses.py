"""Poses from CSV."""

from __future__ import annotations

import math

import numpy as np
import pytest

from lostmotion.errors import InputError
from lostmotion.io.native import arm_of
from lostmotion.io.poses import poses_text, read_poses

ARM = arm_of(
    "x",
    {
        "name": "x",
        "joints": [
            {"name": "A", "type": "revolute", "limits": ["-90 deg", "90 deg"]},
            {"name": "F", "type": "fixed"},
            {"name": "Z axis", "type": "prismatic", "limits": ["0 mm", "300 mm"]},
        ],
    },
)


def refused(tmp_path, text):
    """Return the mistakes of a CSV text."""
    path = tmp_path / "poses.csv"
    path.write_text(text, encoding="utf-8")
    with pytest.raises(InputError) as caught:
        read_poses(path, ARM)
    return caught.value.problems


@pytest.mark.parametrize(
    "text",
    [
        "A [deg],Z axis [mm]\n90,300\n-90,0\n",
        "Z axis[m], A [rad] \r\n0.3,1.5707963267948966\r\n\r\n0,-1.5707963267948966\r\n",
    ],
)
def test_columns_are_read_by_name_and_unit(tmp_path, text):
    """In any order, in any unit of the right kind, and up to the very limits."""
    path = tmp_path / "poses.csv"
    path.write_text(text, encoding="utf-8", newline="")
    assert read_poses(path, ARM) == pytest.approx(
        np.array([[math.pi / 2, 0.3], [-math.pi / 2, 0.0]])
    )


def test_poses_that_are_written_are_read_again(tmp_path):
    """Turning joints in degrees, sliding ones in millimetres, to seven decimals."""
    path, q = tmp_path / "poses.csv", np.array([[-1.1, 0.2], [0.3, 0.012345678]])
    path.write_text(poses_text(ARM, q), encoding="utf-8")
    assert path.read_text().startswith("A [deg],Z axis [mm]\n-63.0253575,200.0000000\n")
    np.testing.assert_allclose(read_poses(path, ARM), q, rtol=0, atol=1e-9)


def test_all_mistakes_of_the_header_come_at_once(tmp_path):
    """An unknown joint, a unit of another kind and a doubled column."""
    keys = {
        problem.key: problem for problem in refused(tmp_path, "A [mm],Z axs [mm],A [deg]\n0,0,0\n")
    }
    assert set(keys) == {"line 1, column 1", "line 1, column 2", "line 1, column 3", "line 1"}
    assert keys["line 1, column 2"].nearest == "Z axis"


def test_all_mistakes_of_the_rows_come_at_once(tmp_path):
    """Cells that are no number, not finite, missing or too many, each with its line."""
    keys = [
        problem.key
        for problem in refused(tmp_path, "A [deg],Z axis [mm]\n1,x\nnan,inf\n1\n1,2,3\n1,2\n")
    ]
    assert keys == [
        "line 2, Z axis [mm]",
        "line 3, A [deg]",
        "line 3, Z axis [mm]",
        "line 4",
        "line 5",
    ]


def test_a_pose_beyond_a_limit_is_reported_with_line_joint_and_limit(tmp_path):
    """The controller would refuse it too."""
    found = refused(tmp_path, "A [deg],Z axis [mm]\n0,0\n\n91,-1\n")
    assert [problem.key for problem in found] == ["line 4, joint A", "line 4, joint Z axis"]
    assert (found[0].found, found[1].found) == ("91 deg", "-1 mm")
    assert "-90 deg to 90 deg" in found[0].expected


@pytest.mark.parametrize(
    "text",
    ["", "A [deg],Z axis [mm]\n", "A,Z axis [mm]\n1,2\n", "A [deg];Z axis [mm]\n1;2\n", "\n1,2\n"],
)
def test_a_file_without_poses_or_units_is_refused(tmp_path, text):
    """Degrees are never guessed."""
    assert refused(tmp_path, text)


def test_the_list_of_mistakes_stays_short(tmp_path):
    """A file of another kind gives twenty mistakes, not a million."""
    for row in ("x,y\n", "999,0\n"):
        found = refused(tmp_path, "A [deg],Z axis [mm]\n" + row * 1000)
        assert len(found) == 21
        assert found[-1].key == "and more"
    assert len(refused(tmp_path, "A [deg],Z axis [mm]\n" + "x,y\n" * 10)) == 20


@pytest.mark.parametrize(
    "cell", ["1_0", "infinity", "nan", "١٢", "１", "0x1p3", "1\u00a0", "", "1e999"]
)
def test_a_number_is_plain_decimal(tmp_path, cell):
    """What Python would read besides is refused in words."""
    (found,) = refused(tmp_path, f"A [deg],Z axis [mm]\n{cell},1\n")
    assert found.key == "line 2, A [deg]"
    assert "plain decimal" in found.expected


def test_many_rows_keep_their_order(tmp_path):
    """Row by row, as the file lists them."""
    path = tmp_path / "poses.csv"
    path.write_text(
        "A [deg],Z axis [mm]\n" + "".join(f"{k % 90},{k % 300}\n" for k in range(100_000)),
        encoding="utf-8",
    )
    q = read_poses(path, ARM)
    assert q.shape == (100_000, 2)
    assert q[777] == pytest.approx([math.radians(777 % 90), 0.001 * (777 % 300)])


@pytest.mark.parametrize(
    "raw",
    [
        b"A [deg],Z axis [mm]\n1,\xff\n",
        b"A [deg],Z axis [mm]\n1,\x00\n",
        b'A [deg],Z axis [mm]\n"' + b"9" * 200_000 + b'",1\n',
        b"A [deg]\r1\r\n",
    ],
)
def test_bytes_that_are_no_table_are_refused(tmp_path, raw):
    """Neither other encodings nor endless cells are read."""
    path = tmp_path / "poses.csv"
    path.write_bytes(raw)
    with pytest.raises(InputError):
        read_poses(path, ARM)
