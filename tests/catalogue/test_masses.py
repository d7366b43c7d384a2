"""Masses of gearboxes: added at the joint where its mass is not stated, included where it is,
reported where unknown.
"""

from __future__ import annotations

import pytest

from lostmotion.analyses.catalog.page import catalogue_sheet
from lostmotion.catalogue.gearbox_row import GearboxRow
from lostmotion.catalogue.search import Criteria
from lostmotion.io import read
from lostmotion.mechanism.arm import STANDARD_GRAVITY
from lostmotion.mechanism.state import state_of
from tests.catalogue.test_own_reducers import ROW

LIMITS = 'type = "revolute"\naxis = "-y"\nlimits = ["-90 deg", "90 deg"]\n'
TWO = (
    'name = "x"\n[[joints]]\nname = "A"\n'
    + LIMITS
    + 'link = { length = "500 mm" }\n[[joints]]\nname = "B"\n'
    + LIMITS
)


def arm_from(tmp_path, text):
    """Read an arm from text."""
    path = tmp_path / "arm.toml"
    path.write_text(text, encoding="utf-8")
    return read(path)


def test_a_heavier_reducer_loads_the_joints_before_it(tmp_path):
    """At the elbow 0.5 m out, an RV-40E of 9.3 kg adds 9.3 x 9.80665 x 0.5 N m at the shoulder, and
    nothing at the elbow.
    """
    arm = arm_from(tmp_path, TWO + 'gearbox = "RV-40E-121"\n')
    assert state_of(arm, [[0.0, 0.3]]).torques[0] == pytest.approx(
        [9.3 * STANDARD_GRAVITY * 0.5, 0.0]
    )
    assert arm.mass == pytest.approx(9.3)
    assert any(
        "added at joints whose own mass is not stated" in note and "B 9.3 kg" in note
        for note in arm.remarks
    )


def test_a_stated_mass_of_a_joint_includes_its_reducer(tmp_path):
    """Nothing is weighed twice: 12 kg stay 12 kg, and zero stays zero."""
    for stated in (12.0, 0.0):
        arm = arm_from(tmp_path, TWO + f'mass = "{stated} kg"\ngearbox = "RV-40E-121"\n')
        assert state_of(arm, [[0.0, 0.3]]).torques[0] == pytest.approx(
            [stated * STANDARD_GRAVITY * 0.5, 0.0]
        )
        assert any("includes" in note and "B 9.3 kg" in note for note in arm.remarks)


def test_a_stated_mass_has_priority_over_the_catalogue(tmp_path):
    """A mass in the gearbox's own table goes before the catalogue's."""
    arm = arm_from(tmp_path, TWO + 'gearbox = { catalogue = "RV-40E-121", mass = "10 kg" }\n')
    assert arm.mass == pytest.approx(10.0)


def test_a_reducer_of_unknown_mass_is_named(tmp_path):
    """A row without a mass weighs nothing, and every result of the arm reports it; with the joint's
    own mass stated nothing is missing.
    """
    arm = arm_from(tmp_path, TWO + 'gearbox = "X-10-81"\n' + ROW)
    assert "mass of X-10-81 not stated: counted as zero" in arm.remarks
    arm = arm_from(tmp_path, TWO + 'mass = "3 kg"\ngearbox = "X-10-81"\n' + ROW)
    assert not any(note.startswith("mass of") for note in arm.remarks)


def test_the_bodies_of_a_urdf_include_their_drives(tmp_path):
    """A URDF has the masses of whole bodies: a reducer in its sidecar adds nothing."""
    (tmp_path / "arm.urdf").write_text(
        """<robot name="x"><link name="base"/><link name="a"><inertial><origin xyz="0.2 0 0"/><mass value="5"/></inertial></link><link name="tip"/>
        <joint name="A" type="revolute"><parent link="base"/><child link="a"/><axis xyz="0 -1 0"/><limit lower="-1" upper="1"/></joint>
        <joint name="B" type="revolute"><parent link="a"/><child link="tip"/><origin xyz="0.5 0 0"/><axis xyz="0 -1 0"/>
        <limit lower="-1" upper="1"/></joint></robot>""",
        encoding="utf-8",
    )
    (tmp_path / "arm.toml").write_text('[joints.B]\ngearbox = "RV-40E-121"\n', encoding="utf-8")
    arm = read(tmp_path / "arm.urdf")
    assert state_of(arm, [[0.0, 0.0]]).torques[0] == pytest.approx(
        [5 * STANDARD_GRAVITY * 0.2, 0.0]
    )
    assert any("includes" in note for note in arm.remarks)


def test_the_catalogue_shows_masses_and_names_rows_without():
    """Each row with its mass; rows without one are named."""
    own = GearboxRow.model_validate(
        {"models": ["X"], "maker": "X", "part": {"stiffness": "20 N m/arcmin"}, "source": "none"}
    )
    sheet = catalogue_sheet(Criteria(ratio=121.0), "gearbox", own=[own])
    assert "mass of X not stated: counted as zero" in sheet.notes
    figures = {row.label: row.cells[3] for section in sheet.sections for row in section.rows}
    assert (figures["RV-40E"].value, figures["RV-40E"].unit) == (9.3, "kg")
    assert any("no output bearing" in note for note in sheet.notes)
    (section,) = catalogue_sheet(Criteria(), name="X", own=[own]).sections
    assert ("mass", "not stated: counted as zero") in [
        (row.label, row.note) for row in section.rows
    ]
