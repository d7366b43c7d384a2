"""Links in arm files: sections within sections, and matrices in files beside the arm's."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np
import pytest

from lostmotion.errors import InputError
from lostmotion.io import read
from lostmotion.io.compliance_csv import read_compliance
from lostmotion.parts.elastic_link import ElasticLink
from lostmotion.parts.link import Link
from lostmotion.parts.material import Material
from tests.io.conftest import JOINT, mistakes
from tests.parts.conditions import STEEL

if TYPE_CHECKING:
    from pathlib import Path

HEAD = 'name = "x"\n'
LOADS, MOTIONS = (
    ["Mx [N m]", "My [N m]", "Mz [N m]", "Fx [N]", "Fy [N]", "Fz [N]"],
    ["rx [rad]", "ry [rad]", "rz [rad]", "x [m]", "y [m]", "z [m]"],
)
BAR = ElasticLink(
    Link(length=0.4, section={"kind": "rectangle", "width": 0.03, "height": 0.05}, material=STEEL),
    np.array([0, 1.0, 0]),
)


def table(kind: str, matrix: np.ndarray, rows: list[str], columns: list[str]) -> str:
    """Write a matrix as a CSV."""
    return "\n".join(
        [
            ",".join([kind, *columns]),
            *(
                ",".join([row, *map(repr, map(float, line))])
                for row, line in zip(rows, matrix, strict=True)
            ),
        ]
    )


def test_one_matrix_in_many_ways_is_one_compliance(tmp_path: Path):
    """As compliance or stiffness, in other units and another order, with comments: what is read is
    the same.
    """
    c = BAR.tip_compliance
    c = c + np.diag(np.diag(c)) * 1e-9
    texts = [
        table("compliance", c, MOTIONS, LOADS),
        table("stiffness", np.linalg.inv(c), LOADS, MOTIONS),
    ]
    order = [5, 3, 4, 2, 0, 1]
    units = np.array([60 * 180 / np.pi] * 3 + [1e3] * 3)
    named = ["rx [arcmin]", "ry [arcmin]", "rz [arcmin]", "x [mm]", "y [mm]", "z [mm]"]
    other = (c * units[:, None])[np.ix_(order, order)]
    texts.append(
        "# from the model of May\n\n"
        + table("compliance", other, [named[k] for k in order], [LOADS[k] for k in order]).replace(
            ",", ";"
        )
    )
    for text in texts:
        path = tmp_path / "link.csv"
        path.write_text(text, encoding="utf-8")
        found = np.array(read_compliance(path)["matrix"])
        scale = np.sqrt(np.diag(c))
        np.testing.assert_allclose(
            found / np.outer(scale, scale), c / np.outer(scale, scale), atol=1e-9
        )


def test_a_matrix_may_state_its_own_weight(tmp_path: Path):
    """Three columns more are what the far end does per gravity."""
    both = np.hstack([BAR.tip_compliance, BAR.own_weight_compliance])
    path = tmp_path / "link.csv"
    path.write_text(
        table("compliance", both, MOTIONS, [*LOADS, "gx [m/s^2]", "gy [m/s^2]", "gz [m/s^2]"]),
        encoding="utf-8",
    )
    np.testing.assert_allclose(
        read_compliance(path)["own_weight"], BAR.own_weight_compliance, rtol=1e-12
    )


GOOD = table("compliance", np.eye(6) * 1e-6, MOTIONS, LOADS)


@pytest.mark.parametrize(
    ("text", "words"),
    [
        ("", "nothing"),
        (GOOD.replace("compliance", "complaince"), "did you mean 'compliance'"),
        (GOOD.replace("Mx [N m]", "Mx [N]"), "not a unit of torque"),
        (GOOD.replace("Mx [N m]", "Mx"), "with its unit"),
        (GOOD.replace("Mx [N m]", "My [N m]"), "once"),
        (GOOD.replace("rx [rad]", "Fx [N]"), "one of rx, ry"),
        ("\n".join(GOOD.splitlines()[:-1]), "once"),
        (GOOD.replace("1e-06", "1e-06x", 1), "6 finite numbers"),
        (GOOD.replace("1e-06", "nan", 1), "6 finite numbers"),
        (GOOD.replace("1e-06,0.0", "1e-06,5e-7", 1), "symmetric"),
        (GOOD.replace("1e-06", "-1e-06", 1), "positive definite"),
    ],
)
def test_what_is_no_matrix_is_reported(tmp_path: Path, text: str, words: str):
    """Each mistake in a matrix is reported with its line, and what is expected there."""
    path = tmp_path / "link.csv"
    path.write_text(text, encoding="utf-8")
    with pytest.raises(InputError) as caught:
        read_compliance(path)
    assert words in str(caught.value)
    assert "link.csv" in str(caught.value)


def test_links_take_matrices_and_sections_by_name(tmp_path: Path):
    """A matrix beside the arm, with its scatter; a stepped link of shared sections and a material
    of the catalogue; nothing counts as unused.
    """
    (tmp_path / "link.csv").write_text(GOOD, encoding="utf-8")
    path = tmp_path / "arm.toml"
    path.write_text(
        HEAD
        + """
        base = { compliance = "link.csv" }
        [sections]
        a = { kind = "tube", outer = "60 mm", wall = "3 mm" }
        b = { kind = "composite", layers = [{ section = "a", material = "aluminium" }, { section = "c", material = "CFRP UD" }] }
        c = { kind = "tube", outer = "64 mm", wall = "2 mm" }
        d = { kind = "stepped", steps = [{ length = "100 mm", section = "b" }, { length = "300 mm", section = "a", material = "mine" }] }
        [materials.mine]
        young = "1 GPa"
        poisson = 0.75
        shear_modulus = "2 GPa"
        density = "1000 kg/m^3"
        """
        + JOINT
        + 'link = { length = "400 mm", compliance = { file = "link.csv", scatter = "5 %" } }\n'
        + JOINT.replace('"A"', '"B"')
        + 'link = { length = "400 mm", section = "d" }\n'
        + JOINT.replace('"A"', '"C"')
        + (
            'link = { length = "400 mm", measured = { force = "100 N", deflection = "0.2 mm", '
            'slope = "2 arcmin" } }\n'
        ),
        encoding="utf-8",
    )
    arm = read(path)
    assert arm.joints[0].link.compliance.scatter == pytest.approx(0.05)
    assert arm.joints[0].link.compliance.matrix[3][3] == pytest.approx(1e-6)
    assert arm.base.compliance.matrix[0][0] == pytest.approx(1e-6)
    assert arm.joints[1].link.section.steps[0].section.layers[1].material.young == pytest.approx(
        135e9
    )
    assert arm.joints[1].link.section.steps[1].material.shear == pytest.approx(2e9)
    assert not arm.notes


@pytest.mark.parametrize(
    "name", ["../link.csv", "/etc/hostname", "a/../../link.csv", "", "nowhere.csv"]
)
def test_a_matrix_lies_beside_its_arm(tmp_path: Path, name: str):
    """Nothing outside the arm's folder is read, and a missing file is reported."""
    (tmp_path / "link.csv").write_text(GOOD, encoding="utf-8")
    folder = tmp_path / "arm"
    folder.mkdir()
    path = folder / "arm.toml"
    path.write_text(
        f'{HEAD}{JOINT}link = {{ length = "400 mm", compliance = "{name}" }}\n', encoding="utf-8"
    )
    (problem,) = mistakes(path)
    assert (
        "no such file" in problem.found
        if name == "nowhere.csv"
        else problem.key == "joints.A.link.compliance"
    )


@pytest.mark.parametrize(
    ("lines", "key"),
    [
        (
            (
                'section = { kind = "stepped", steps = [{ length = "400 mm", section = "nope" }] '
                '}, material = "steel"'
            ),
            "section.steps[0].section",
        ),
        (
            (
                'section = { kind = "stepped", steps = [{ length = "400 mm", section = "loop" }] '
                '}, material = "steel"'
            ),
            "section.steps[0].section",
        ),
        (
            (
                'section = { kind = "tapered", stations = [{ at = 3, section = "t" }, { at = "400 '
                'mm", section = "t" }] }, material = "steel"'
            ),
            ".stations[0].at",
        ),
        ("compliance = { matrix = [[1]] }", "compliance"),
        ('measured = { force = "1 N", deflection = "1 mm", slope = "9 deg" }', "link"),
    ],
)
def test_a_slip_within_a_section_has_its_key(mistakes_in, lines: str, key: str):
    """Names that lead nowhere, sections made of themselves and bare numbers are reported at their
    place.
    """
    shared = (
        '[sections]\nt = { kind = "rod", diameter = "9 mm" }\nloop = { kind = "stepped", steps = '
        '[{ length = "400 mm", section = "t" }] }\n'
    )
    found = mistakes_in(f'{HEAD}{shared}{JOINT}link = {{ length = "400 mm", {lines} }}\n')
    assert any(where.endswith(key) for where in found), found


def test_no_section_is_made_of_itself(mistakes_in):
    """Two sections that name each other, and one that names itself, are refused in a moment."""
    found = mistakes_in(
        HEAD
        + (
            '[sections]\na = { kind = "composite", layers = [{ section = "b", material = "steel" '
            "}] }\n"
        )
        + (
            'b = { kind = "composite", layers = [{ section = "a", material = "steel" }, { section '
            '= "b", material = "steel" }] }\n'
        )
        + JOINT
        + 'link = { length = "400 mm", section = "a" }\n',
    )
    assert {
        "sections.a.layers[0].section",
        "sections.b.layers[0].section",
        "sections.b.layers[1].section",
    } <= set(found)


def test_a_link_needs_the_density_of_its_material_and_a_gearbox_does_not(tmp_path: Path):
    """A link bends under its own weight, which a material without density does not state; a drawn
    gearbox has no use for it.
    """
    path = tmp_path / "arm.toml"
    material = '[materials.mine]\nyoung = "1 GPa"\npoisson = 0.3\n'
    link = (
        'link = { length = "400 mm", section = { kind = "tube", outer = "60 mm", wall = "3 mm" }, '
        'material = "mine" }\n'
    )
    path.write_text('name = "light"\n' + material + JOINT + link, encoding="utf-8")
    with pytest.raises(InputError) as caught:
        read(path)
    (problem,) = caught.value.problems
    assert problem.key == "joints.A.link"
    assert "density" in problem.expected
    assert Material(young=1e9, poisson=0.3).density is None
