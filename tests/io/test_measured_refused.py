"""Measured files that are wrong in one way each: one message that names file, place, what was found
and what belongs there.
"""

import pytest

import lostmotion
from tests.command import carried_out

HEAD = "pose,cycle,x [mm],y [mm],z [mm],xc [mm],yc [mm],zc [mm]\n"
ROWS = "P1,1,600,0,400,600,0,400\nP1,2,600.1,0,400,600,0,400\n"
LINE = "path,cycle,x [mm],y [mm],z [mm]\n" + "".join(
    f"A-B,{cycle},{x},0,0\n" for cycle in (1, 2) for x in range(10)
)


@pytest.mark.parametrize(
    ("text", "found"),
    [
        ("", "no reading"),
        (HEAD, "no reading"),
        (ROWS * 2, "numbers, 'P1,1,600,0,400,600,0,400'"),
        (HEAD.replace("x [mm]", "x", 1) + ROWS, "no unit"),
        (HEAD.replace("x [mm]", "x [deg]", 1) + ROWS, "'deg' is not a unit of length"),
        (HEAD.replace("y [mm]", "y [furlong]", 1) + ROWS, "'furlong' is not a known unit"),
        (HEAD.replace(",z [mm]", "", 1) + ROWS.replace(",400,600", ",600"), "x, y without z"),
        (
            HEAD.replace("x [mm]", "x [mm],x [mm]", 1)
            + ROWS.replace("600", "600,600", 1).replace("600.1", "600.1,600.1"),
            "'x' a second time",
        ),
        (HEAD.replace(",", "\t") + ROWS.replace(",", "\t"), "cells between tabs"),
        (HEAD.replace(",", "|") + ROWS.replace(",", "|"), "cells between '|'"),
        (HEAD + ROWS + "P1,3,here,0,400,600,0,400\n", "'here'"),
        (HEAD + "P1,1,nan,0,400,600,0,400\nP1,2,600,0,nan,600,0,400\n", "no reading in any row"),
        (HEAD + "P1,1,,0,400,600,0,400\n", "''"),
        (
            HEAD
            + ROWS.replace("600,0,400,", "0.6,0,0.4,").replace("600.1,0,400,", "0.6001,0,0.4,"),
            "0.001 times as far in all rows",
        ),
        ("PK\x03\x04" + HEAD, "an Excel workbook"),
        (HEAD + ROWS + "P1,3,1e12,0,400,600,0,400\n", "beyond any robot"),
        (HEAD + ROWS + "P1,third,600,0,400,600,0,400\n", "'third'"),
        (HEAD + ROWS + "P1,3,600\n", "3 cells"),
        (HEAD + ROWS + "P1,3,600,0,400,600,0,400,7\n", "9 cells"),
        (HEAD + ROWS + "P1,3,\x1b[2Jx,0,400,600,0,400\n", r"'\x1b[2Jx'"),
        (
            HEAD + ROWS + "P1,3,600,0,400,601,0,400\n",
            "another commanded position of pose P1 than in line 2",
        ),
        (HEAD + ROWS + "P1,2,600.5,0,400,600,0,400\n", "line 3 has another x"),
        (HEAD + '"P1\nb",1,600,0,400,600,0,400\n' + ROWS, "a quoted cell over several lines"),
        (
            HEAD + ROWS.replace("600,0", '"1,600",0', 1).replace("600.1", '"1,601"'),
            "2 numbers with a comma",
        ),
        (
            HEAD.replace("cycle", "cycle,load [%]")
            + ROWS.replace(",1,", ",1,-5,", 1).replace(",2,", ",2,100,", 1),
            "-5 %",
        ),
        ("cycle,x [mm],y [mm],z [mm]\n1,1,2,3\n", "neither pose nor path nor xc, yc, zc"),
        ("path,x [mm],y [mm],z [mm]\nP2-P4,1,2,3\n", "path without cycle"),
        (LINE, "does not name two poses"),
        (
            (
                "pose,side,cycle,x [mm],y [mm],z [mm]\nP1,x,1,1,2,3\nP1,x,2,1,2,3.1\nP2,,1,1,2,3\n"
                "P2,,2,1,2,3.1\n"
            ),
            "a side at all visits to P1",
        ),
        (HEAD + ROWS.splitlines()[0] + "\n", "1 visit to 1 pose"),
        (
            HEAD + ROWS.splitlines()[0] + "\n" + ROWS.splitlines()[0] + "\n",
            "1 visit to 1 pose, besides 1 duplicate row",
        ),
    ],
)
def test_a_wrong_file_is_refused_by_one_message(tmp_path, text, found):
    """One mistake in a file of measured visits gives one message, and nothing of the file reaches
    the terminal raw.
    """
    path = tmp_path / "visits.csv"
    path.write_text(text, encoding="utf-8")
    with pytest.raises(lostmotion.InputError) as caught:
        lostmotion.iso9283(measured=path)
    said = str(caught.value)
    assert said.startswith(f"1 mistake\n{path}")
    assert found in said.partition("  expected")[0]
    assert "\x1b" not in said


def test_a_refused_file_leaves_no_folder(tmp_path):
    """The command ends with exit code 2, the message on the error stream, and writes nothing."""
    path = tmp_path / "visits.csv"
    path.write_text(HEAD + ROWS + "P1,3,here,0,400,600,0,400\n", encoding="utf-8")
    done = carried_out("iso9283", "--measured", path, "--out", tmp_path / "out", cwd=tmp_path)
    assert done.returncode == 2
    assert done.stderr.startswith("lostmotion: 1 mistake\n")
    assert not done.stdout.strip()
    assert list(tmp_path.iterdir()) == [path]
