"""Corrected files for a machine: the arm stands where the file wants it, by an equilibrium of its
own.
"""

from __future__ import annotations

import csv

import numpy as np
import pytest

import lostmotion
from tests.controller_model.equilibrium import soft_arm
from tests.parts.random_arms import EXAMPLES

# A row of docs/validation.md each: quantity, compared with, agreement, other files.
VALIDATES = (
    (
        "compensate: corrected joint values in a file",
        "where a soft arm of six joints settles, by SciPy rotations and iteration",
        "below 1e-4 of the error",
    ),
)


def write(path, header, rows):
    """Write a CSV and return its path."""
    with path.open("w", encoding="utf-8", newline="") as file:
        csv.writer(file).writerows([header, *rows])
    return path


def values(path, names):
    """Return the joint values of a corrected file in rad."""
    with path.open(encoding="utf-8") as file:
        rows = list(csv.DictReader(file))
    return np.radians([[float(row[f"{name} [deg]"]) for name in names] for row in rows]), rows


@pytest.fixture(scope="module")
def soft():
    """Return a soft arm, and poses away from singular ones."""
    arm = soft_arm(6, 6, droop=0.02, bend=0.003)
    q = np.random.default_rng(3).uniform(-2, 2, (400, 6))
    model = lostmotion.controller(arm.described())
    singular = np.linalg.svd(model.predict(q).jacobian[:, 3:], compute_uv=False)[:, -1]
    return arm, q[singular > 0.15][:40]


def test_joint_values_out_stand_where_those_in_do_without_errors(soft, tmp_path):
    """Columns in any order and unit, others kept as they are; the corrected file leaves less than
    1e-4 of the error.
    """
    arm, q = soft
    names = [f"J{k}" for k in range(6)]
    header = [*(f"{name} [rad]" for name in reversed(names)), "feature"]
    rows = [[*map(repr, each[::-1].tolist()), f"p{k}"] for k, each in enumerate(q)]
    poses, out = write(tmp_path / "poses.csv", header, rows), tmp_path / "out" / "sent.csv"
    found = lostmotion.compensate(arm.described(), poses=poses, out=out)
    command, back = values(out, names)
    assert [row["feature"] for row in back] == [f"p{k}" for k in range(len(q))]
    wanted = arm.moved(q)[1][:, -1]
    before, after = (np.linalg.norm(arm.settled(each)[1] - wanted, axis=1) for each in (q, command))
    assert (after < 1e-4 * before + 1e-8).all()
    assert found["rows"] == len(q)
    assert found["without"]["worst"] == pytest.approx(before.max(), rel=1e-6)
    assert found["left"]["worst"] < 1e-4 * before.max()
    assert max(found["changed"].values()) == pytest.approx(np.abs(command - q).max(), abs=1e-8)


def test_poses_of_the_tool_in_joint_values_out(soft, tmp_path):
    """The arm stands at the stated points, in mm; of five poses at most one is near singular."""
    arm, q = soft
    wanted = arm.moved(q)[1][:5, -1]
    poses = write(tmp_path / "tool.csv", ["x [mm]", "y [mm]", "z [mm]"], 1e3 * wanted)
    lostmotion.compensate(arm.described(), poses=poses, out=tmp_path / "sent.csv")
    command, _ = values(tmp_path / "sent.csv", [f"J{k}" for k in range(6)])
    stands = arm.settled(command)[1]
    assert np.sort(np.linalg.norm(stands - wanted, axis=1))[:4].max() < 1e-5


def test_the_sides_of_a_path_leave_the_scatter_of_play_alone(tmp_path):
    """Drives that carry no load rest behind their last motion by half their play, mu +- sigma: the
    error falls from the r.m.s. of the half play to its standard deviation, over drawn robots.
    """
    arm, names = lostmotion.read(EXAMPLES / "z-arm.toml"), ["O", "A", "B", "C", "roll"]
    poses = EXAMPLES / "controller" / "poses.csv"
    q, _ = values(poses, names)
    side = np.sign(np.diff(q, axis=0))
    wanted = lostmotion.state_of(arm, q[1:]).frames[-1][:, :3, 3]
    minute, rng = np.pi / 180 / 60, np.random.default_rng(5)
    half = rng.normal(0.25, 0.1 / 3, (1000, 2)) * minute  # of O and roll: 0.5 arcmin +- 0.2 arcmin
    left = []
    for path in (False, True):
        out = tmp_path / f"{path}.csv"
        lostmotion.compensate(arm, poses=poses, out=out, path=path)
        command = np.tile(values(out, names)[0][1:, None], (1, len(half), 1))
        command[..., [0, 4]] -= side[:, None, [0, 4]] * half
        stands = lostmotion.state_of(arm, command.reshape(-1, 5)).settled().frames[-1][:, :3, 3]
        away = stands.reshape(*command.shape[:2], 3) - wanted[:, None]
        left.append(np.sqrt((away**2).sum(axis=2).mean(axis=1)))
    np.testing.assert_allclose(left[1] / left[0], (0.1 / 3) / np.hypot(0.25, 0.1 / 3), rtol=0.06)
    assert (left[0] > 20e-6).all()


def test_a_program_keeps_everything_but_the_ends_of_its_moves(tmp_path):
    """A gantry whose joints are X, Y and Z: comments, feeds, extruder and other lines stay; the
    corrected values are those of the controller with the sides of the path.
    """
    program = tmp_path / "part.gcode"
    program.write_text(
        "; head\nG28\nG21 G90\nM104 S200\nG1 X100 F6000\nG1 X100 Y200 Z50 E1.5 ; first\n"
        "G1 X700 Y300 E2\nG0 Z100\n",
        encoding="utf-8",
    )
    arm = lostmotion.read(EXAMPLES / "gantry.toml")
    found = lostmotion.compensate(arm, poses=program, out=tmp_path / "out.gcode")
    lines = (tmp_path / "out.gcode").read_text(encoding="utf-8").splitlines()
    assert lines[:5] == ["; head", "G28", "G21 G90", "M104 S200", "G1 X100 F6000"]
    assert (found["rows"], found["unknown"]) == (3, 1)
    q = np.array([[0.1, 0.2, 0.05], [0.7, 0.3, 0.05], [0.7, 0.3, 0.1]])
    side = [[0, 0, 0], [1, 1, 0], [1, 1, 1]]
    sent = 1e3 * lostmotion.controller(arm).compensate(q, side=side, passes=2).command
    words = [
        [f"{letter}{value:.5f}" for letter, value in zip("XYZ", row, strict=True)] for row in sent
    ]
    (x, y, z), second, third = words
    assert lines[5] == f"G1 {x} {y} {z} E1.5 ; first"
    assert lines[6] == f"G1 {second[0]} {second[1]} E2 {second[2]}"
    assert lines[7] == f"G0 {third[2]} {third[0]} {third[1]}"
    assert second[0] != "X700.00000"


def test_relative_moves_lead_where_absolute_ones_do(tmp_path):
    """The same path in G91, in inches, as slicers and mills end a program: the sums of what is sent
    are the positions that are sent in G90, to half a digit however many moves.
    """
    rng = np.random.default_rng(2)
    to = np.cumsum(np.round(rng.uniform(-0.2, 0.2, (300, 3)), 4), axis=0)
    to = np.round(to - to.min(axis=0) + 1, 4)
    lines = [" ".join(f"{a}{v:.4f}" for a, v in zip("XYZ", row, strict=True)) for row in to]
    steps = [
        " ".join(f"{a}{v:.4f}" for a, v in zip("XYZ", row, strict=True))
        for row in np.diff(to, axis=0)
    ]
    first = f"G20 G90\nG0 {lines[0]}\n"
    texts = [
        first + "".join(f"G1 {each}\n" for each in lines[1:]),
        first + "G91\nG1 E-2\n" + "".join(f"G1 {each}\n" for each in steps),
    ]
    sent = []
    for number, text in enumerate(texts):
        (tmp_path / "in.nc").write_text(text, encoding="utf-8")
        out = tmp_path / f"out{number}.nc"
        lostmotion.compensate(EXAMPLES / "gantry.toml", poses=tmp_path / "in.nc", out=out)
        moves = [each for each in out.read_text(encoding="utf-8").splitlines() if "X" in each]
        sent.append([[float(word[1:]) for word in each.split()[1:]] for each in moves])
    absolute, relative = np.array(sent[0]), np.cumsum(sent[1], axis=0)
    assert np.abs(absolute - to).max() > 1e-3
    np.testing.assert_allclose(relative, absolute, atol=1.1e-5)


def test_a_program_of_tool_points_leads_a_soft_arm_there(soft, tmp_path):
    """A machine whose firmware computes the joint values is sent tool points beside the wanted
    ones.
    """
    arm, q = soft
    wanted = arm.moved(q)[1][:1, -1]
    text = "G1 " + " ".join(f"{a}{1e3 * v:.6f}" for a, v in zip("XYZ", wanted[0], strict=True))
    (tmp_path / "part.nc").write_text(text + "\n", encoding="utf-8")
    lostmotion.compensate(arm.described(), poses=tmp_path / "part.nc", out=tmp_path / "out.nc")
    sent = (tmp_path / "out.nc").read_text(encoding="utf-8").split()[1:]
    moved = np.array([float(word[1:]) for word in sent]) - 1e3 * wanted[0]
    assert 0.5 < np.linalg.norm(moved) < 100


@pytest.mark.parametrize(
    ("text", "found"),
    [
        ("G1 X1 Y1 Z1\nG2 X3 Y2 I1 J0\n", "line 2.*\n.*an arc, G2"),
        ("G91\nG1 X1 Y1 Z1\n", "no straight move to a position"),
        ("G92 X0\nG1 X1 Y1 Z1\n", "line 1.*\n.*a shifted origin"),
        ("G1 X1 Y1 Z1 A3\n", "line 1.*\n.*A of a machine"),
        ("G1 X1 Y1 Z1\nG1 X9000\n", "line 2.*\n.*X9000"),
        ("M3\n", "no straight move"),
    ],
)
def test_what_cannot_be_corrected_is_refused_with_its_line(tmp_path, text, found):
    """Arcs, relative moves from nowhere, shifted origins, other axes, positions outside the limits."""
    program = tmp_path / "part.gcode"
    program.write_text(text, encoding="utf-8")
    with pytest.raises(lostmotion.InputError, match=found):
        lostmotion.compensate(EXAMPLES / "gantry.toml", poses=program, out=tmp_path / "out.gcode")
    assert not (tmp_path / "out.gcode").exists()


def test_an_earlier_file_stays(soft, tmp_path):
    """Without `force`."""
    arm, q = soft
    poses = write(tmp_path / "p.csv", [f"J{k} [rad]" for k in range(6)], q[:1].tolist())
    with pytest.raises(lostmotion.OutputExistsError):
        lostmotion.compensate(arm.described(), poses=poses, out=poses)
