"""A user's own reducers: in the arm file, in a file of rows beside it, and validated as those of
the package.
"""

from __future__ import annotations

import pytest

from lostmotion.catalogue.gearboxes import by_model, find_gearbox, gearboxes
from lostmotion.catalogue.printed_row import CheckedRow
from lostmotion.errors import InputError
from lostmotion.io import read
from lostmotion.io.own_reducers import read_reducers
from lostmotion.io.part_file import read_gearbox
from tests.io.conftest import JOINT, mistakes_in  # noqa: F401 - the fixture
from tests.parts.conditions import ARCMIN

HEAD = 'name = "x"\n'
PART = 'part = { rated_torque = "50 N m", stiffness = "20 N m/arcmin", backlash = "1 arcmin" }\n'
ROW = f'[[reducers]]\nmodels = ["X-10"]\nmaker = "X"\n{PART}source = "measured on 5 pieces"\n'
USE = JOINT + 'gearbox = "X-10-81"\n'


def written(tmp_path, text, name="arm.toml"):
    """Write a file and return its path."""
    path = tmp_path / name
    path.parent.mkdir(exist_ok=True, parents=True)
    path.write_text(text, encoding="utf-8")
    return path


@pytest.mark.parametrize(
    "row", [pytest.param(row, id=f"{row.models[0]}, ratio {row.ratios}") for row in gearboxes()]
)
def test_the_rows_of_the_package_pass_the_users_check(row):
    """Every row of the package passes the validation of a user's row."""
    assert isinstance(row.figures, CheckedRow)
    assert row.figures.part.zones


def test_rows_in_the_arm_file_are_found_by_model(tmp_path):
    """A joint that names a row of the same file has its figures, with a note of their source."""
    arm = read(written(tmp_path, HEAD + USE + ROW))
    gearbox = arm.moving[0].gearbox
    assert (gearbox.ratio, gearbox.model) == (81, "X-10-81")
    assert gearbox.play.nominal == pytest.approx(ARCMIN)
    assert "measured on 5 pieces" in arm.notes[0]


@pytest.mark.parametrize("name", ["my.toml", "parts/my.toml", "./my.toml"])
def test_rows_may_be_in_a_file_beside_the_arm(tmp_path, name):
    """The arm names a file of rows in its folder or below it; rows in the arm file can be used
    together with it.
    """
    written(tmp_path, ROW, name)
    own = ROW.replace("X-10", "Y-20")
    arm = read(
        written(
            tmp_path,
            HEAD
            + f'catalogue = "{name}"\n'
            + USE
            + JOINT.replace('"A"', '"B"')
            + 'gearbox = "Y-20"\n'
            + own,
        )
    )
    assert [joint.gearbox.model for joint in arm.moving] == ["X-10-81", "Y-20"]


def test_own_rows_have_priority_over_those_of_the_package(tmp_path):
    """A measured RV-40E is the user's; other reducers of the package are found as before."""
    arm = read(
        written(
            tmp_path,
            HEAD
            + USE.replace("X-10-81", "RV-40E-121")
            + JOINT.replace('"A"', '"B"')
            + 'gearbox = "RV-20E"\n'
            + ROW.replace("X-10", "RV-40E"),
        )
    )
    assert arm.moving[0].gearbox.rated_torque == 50
    assert arm.moving[1].gearbox.rated_torque == 167


def test_a_class_of_ratios_holds_for_own_rows_too(mistakes_in):  # noqa: F811 - the fixture
    """With rows for 50 and above, a ratio of 40 is refused, and the model without its ratio."""
    rows = ROW.replace("maker", "ratio = 50\nmaker") + ROW.replace(
        "maker", "ratio_above = 50\nmaker"
    )
    assert (
        "50 or above 50"
        in mistakes_in(HEAD + USE.replace("81", "40") + rows)["joints.A.gearbox"].expected
    )
    assert (
        "its ratio appended"
        in mistakes_in(HEAD + USE.replace("-81", "") + rows)["joints.A.gearbox"].expected
    )


def test_the_nearest_own_row_is_offered(mistakes_in):  # noqa: F811 - the fixture
    """A misspelt own model is refused with the nearest one, and its maker is named."""
    found = mistakes_in(
        HEAD + USE.replace("X-10-81", "Xrated-1") + ROW.replace("X-10", "Xrated-10")
    )["joints.A.gearbox"]
    assert found.nearest == "Xrated-10"
    assert "by X" in found.expected


@pytest.mark.parametrize(
    ("text", "key", "expected"),
    [
        (ROW.replace("maker", "makr"), "reducers[0].maker", "text"),
        (ROW.replace("backlash", "backlsh"), "reducers[0].part.backlsh", "backlash"),
        (
            ROW.replace('"20 N m/arcmin"', '"20 N m"'),
            "reducers[0].part.stiffness",
            "angular stiffness",
        ),
        (
            ROW.replace("part = {", 'part = { kind = "worm",'),
            "reducers[0].part.kind",
            '"catalogue"',
        ),
        (
            ROW.replace("maker", 'upper_limits = ["hysteresis"]\nmaker'),
            "reducers[0]",
            "keys that part states",
        ),
        (ROW.replace("maker", "ratio = 3\nratio_above = 2\nmaker"), "reducers[0]", "one of them"),
        (ROW.replace("maker", "ratio = -3\nmaker"), "reducers[0].ratio", "above zero"),
        (ROW.replace('"measured on 5 pieces"', '""'), "reducers[0].source", "at least 1"),
        (ROW + ROW, "reducers", "one row for a model"),
        ("reducers = 3\n", "reducers", "a list of rows"),
        ("reducers = [3]\n", "reducers[0]", "a row"),
        ('catalogue = "/etc/passwd"\n', "catalogue", "in the arm's folder"),
        ('catalogue = "../my.toml"\n', "catalogue", "in the arm's folder"),
        ('catalogue = "a/../my.toml"\n', "catalogue", "in the arm's folder"),
        ("catalogue = 3\n", "catalogue", "the name of a file"),
        ('catalogue = ""\n', "catalogue", "the name of a file"),
        ('catalogue = "a\\u0000b"\n', "catalogue", "the name of a file"),
        ('catalogue = "nowhere.toml"\n', "", "a file that exists"),
        ('catalogue = "."\n', "", "a text file"),
    ],
)
def test_a_mistake_in_own_rows_is_reported(mistakes_in, text, key, expected):  # noqa: F811 - the fixture
    """Every key of a row is checked as in the package, and files outside the folder are not
    opened.
    """
    top, rows = ("", text) if text.startswith("[[") else (text, "")
    found = mistakes_in(HEAD + top + JOINT + rows)
    assert key in found
    assert expected in found[key].expected


def test_all_mistakes_are_reported_at_once(mistakes_in):  # noqa: F811 - the fixture
    """Rows, the file of rows and the joints are checked in one pass."""
    found = mistakes_in(
        HEAD
        + 'catalogue = "nowhere.toml"\n'
        + JOINT
        + 'gearbox = "RV-41E"\nmas = "1 kg"\n'
        + ROW.replace("maker", "makr")
    )
    assert {"", "joints.A.gearbox", "joints.A.mas", "reducers[0].makr", "reducers[0].maker"} == set(
        found
    )


def test_a_link_out_of_the_folder_is_refused(tmp_path):
    """A symbolic link out of the folder is not followed."""
    written(tmp_path, ROW, "outside.toml")
    (tmp_path / "arm").mkdir()
    (tmp_path / "arm" / "my.toml").symlink_to(tmp_path / "outside.toml")
    with pytest.raises(InputError, match="leads out of the folder"):
        read(written(tmp_path, HEAD + 'catalogue = "my.toml"\n' + USE, "arm/arm.toml"))


def test_a_file_of_rows_contains_rows(tmp_path):
    """Read on its own it yields rows, or the mistakes in them; any other content is a mistake; an
    arm file yields its rows.
    """
    assert [row.models for row in read_reducers(written(tmp_path, ROW))] == [["X-10"]]
    assert [row.models for row in read_reducers(written(tmp_path, HEAD + USE + ROW))] == [["X-10"]]
    for text, said in (
        (ROW.replace("reducers", "reducer"), "did you mean 'reducers'"),
        (ROW.replace("50 N m", "50 N"), "not a unit of torque"),
        ("", "nothing"),
    ):
        with pytest.raises(InputError, match=said):
            read_reducers(written(tmp_path, text))


def test_a_urdfs_sidecar_may_have_own_rows(tmp_path):
    """Files named in a URDF's sidecar are found in the sidecar's folder."""
    robot = (
        '<robot name="r"><link name="a"/><link name="b"/><joint name="j" '
        'type="revolute"><parent link="a"/><child link="b"/>'
        '<axis xyz="0 0 1"/><limit lower="-1" upper="1" effort="1" velocity="1"/></joint></robot>'
    )
    written(tmp_path, robot, "r.urdf")
    written(tmp_path, ROW, "my.toml")
    written(tmp_path, 'catalogue = "my.toml"\n[joints.j]\ngearbox = "X-10-81"\n', "r.toml")
    assert read(tmp_path / "r.urdf").moving[0].gearbox.ratio == 81


def test_rows_are_found_by_any_of_their_models():
    """A row with three names is found by each, also a user's."""
    row = next(row for row in gearboxes() if row.models[0] == "CSG-58" and row.applies_to(100))
    own = by_model([row])
    assert all(find_gearbox(model, 100, own)[0] is row for model in row.models)


def test_a_part_by_itself_may_have_own_rows(tmp_path):
    """A file about one gearbox finds it among the rows beside it."""
    written(tmp_path, ROW, "my.toml")
    part = read_gearbox(
        written(tmp_path, 'catalogue = "my.toml"\ngearbox = "X-10-81"\n', "part.toml")
    ).part
    assert (part.ratio, part.rated_torque) == (81, 50)
