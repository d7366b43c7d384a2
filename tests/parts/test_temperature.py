"""Thermal expansion of links against closed forms: free growth, a temperature difference across a
section, and bonded layers.
"""

from __future__ import annotations

import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from pydantic import ValidationError

from lostmotion.mechanism.arm import Arm
from lostmotion.parts.bearing.pair import RollerPair
from lostmotion.parts.elastic_link import ElasticLink
from lostmotion.parts.link import Link
from lostmotion.parts.profile import Composite
from lostmotion.parts.term import Condition, Motion
from lostmotion.units import Toleranced

# A row of docs/validation.md each: quantity, compared with, agreement, other files.
VALIDATES = (
    (
        "thermal expansion",
        (
            "arms of other lengths; free growth, cones, sandwich and Timoshenko's bimetal in "
            "closed form; sizing against the pose matrix; "
            "simulated robots"
        ),
        "1e-9; 1e-9; 1e-9; 2 %",
        "tests/error_model/test_temperature.py",
    ),
)

STEEL = {"young": 210e9, "poisson": 0.3, "density": 7850.0, "expansion": 12e-6}
ALUMINIUM = {"young": 70e9, "poisson": 0.33, "density": 2700.0, "expansion": 23e-6}
TUBE = {"kind": "tube", "outer": 0.06, "wall": 0.003}
LENGTH = 0.4
# About it lies the width of the section, so a link along x has its height along -z of the joint's
# frame.
AXIS = np.array([0, 1.0, 0])


def growth(rise: float, **fields: object) -> np.ndarray:
    """Return the twist of the tip at a temperature rise (K) and by the link's own temperature
    difference.
    """
    link = ElasticLink(Link(**{"length": LENGTH, **fields}), AXIS)
    at = Condition(np.zeros(1), np.zeros((6, 1)), np.zeros((3, 1)), rise)
    names = ("thermal expansion", "thermal bending")
    terms = [
        term
        for term in link.terms(Motion(np.zeros(6), rise=Toleranced(rise)))
        if term.name in names
    ]
    return np.asarray(
        sum((term.scale * term.form.screw(at)[:, 0] for term in terms), start=np.zeros(6))
    )


@given(rise=st.floats(-80, 120), length=st.floats(0.05, 2))
@settings(max_examples=30, deadline=None)
def test_a_free_link_grows_along_itself(rise: float, length: float):
    """A link that nothing restrains becomes longer by expansion x rise x length, and neither bends
    nor turns, whatever its section.
    """
    for section in (
        TUBE,
        {"kind": "rectangle", "width": 0.03, "height": 0.05},
        {"kind": "rod", "diameter": 0.02},
    ):
        found = growth(rise, length=length, section=section, material=STEEL)
        np.testing.assert_allclose(
            found, [0, 0, 0, 12e-6 * rise * length, 0, 0], rtol=1e-12, atol=1e-18
        )


def test_growth_follows_the_line_to_the_next_seat():
    """A link whose tip is turned and offset grows along the straight line to it, stated in the
    tip's axes.
    """
    link = Link(
        tip={"xyz": (0.3, 0.0, 0.4), "rpy": (0.2, -0.7, 1.1)}, section=TUBE, material=ALUMINIUM
    )
    found = ElasticLink(link, AXIS).terms(Motion(np.zeros(6), rise=Toleranced(10.0)))[-1].form
    at = Condition(np.zeros(1), np.zeros((6, 1)), np.zeros((3, 1)), 10.0)
    np.testing.assert_allclose(
        link.tip_pose[:3, :3] @ found.screw(at)[3:, 0],
        230e-6 * np.array([0.3, 0, 0.4]),
        rtol=1e-12,
        atol=1e-18,
    )
    np.testing.assert_allclose(found.screw(at)[:3], 0, atol=1e-18)


def test_steps_of_two_materials_grow_one_after_the_other():
    """Steel and aluminium in a row: the growths of the pieces add up."""
    steps = [
        {"length": 0.1, "section": TUBE, "material": STEEL},
        {"length": 0.3, "section": TUBE, "material": ALUMINIUM},
    ]
    found = growth(20.0, section={"kind": "stepped", "steps": steps})
    assert found[3] == pytest.approx(20 * (12e-6 * 0.1 + 23e-6 * 0.3), rel=1e-12)


def test_a_stated_expansion_replaces_that_of_the_material():
    """A link with a measured expansion, or without any section, grows by what it states."""
    assert growth(10.0, section=TUBE, material=STEEL, expansion=1e-6)[3] == pytest.approx(
        1e-6 * 10 * LENGTH, rel=1e-12
    )
    assert growth(10.0, expansion=-2e-6)[3] == pytest.approx(-2e-6 * 10 * LENGTH, rel=1e-12)
    assert growth(10.0, rigid=True, expansion="23 µm/m/K")[3] == pytest.approx(
        23e-6 * 10 * LENGTH, rel=1e-12
    )


def test_without_a_temperature_or_an_expansion_nothing_grows():
    """No term where no temperature is stated, where the material states no expansion, and where the
    temperature is that of the drawing.
    """
    link = Link(length=LENGTH, section=TUBE, material=STEEL)
    assert not any(
        "temperature" in term.name or "thermal" in term.name
        for term in ElasticLink(link, AXIS).terms(Motion(np.zeros(6)))
    )
    unknown = {key: value for key, value in STEEL.items() if key != "expansion"}
    assert not growth(30.0, section=TUBE, material=unknown).any()
    assert not growth(0.0, section=TUBE, material=STEEL).any()


@pytest.mark.parametrize(
    ("section", "height"),
    [
        (TUBE, 0.06),
        ({"kind": "rod", "diameter": 0.05}, 0.05),
        ({"kind": "rectangle", "width": 0.03, "height": 0.08}, 0.08),
        ({"kind": "box", "width": 0.05, "height": 0.07, "wall": 0.003}, 0.07),
        ({"kind": "I", "width": 0.05, "height": 0.09, "web": 0.004, "flange": 0.006}, 0.09),
        (
            {
                "kind": "custom",
                "area": 5e-4,
                "i_y": 2e-7,
                "i_z": 2e-7,
                "torsion": 4e-7,
                "height": 0.1,
            },
            0.1,
        ),
    ],
)
def test_a_difference_across_the_section_bends_the_link(section: dict[str, object], height: float):
    """Curvature expansion x difference / height: the tip turns by that times the length and
    deflects by half of it times the length squared.
    """
    found = growth(0.0, section=section, material=ALUMINIUM, temperature_difference=8.0, up="z")
    curvature = 23e-6 * 8 / height
    np.testing.assert_allclose(
        found, [0, curvature * LENGTH, 0, 0, 0, -curvature * LENGTH**2 / 2], rtol=1e-12, atol=1e-18
    )


def test_the_warm_side_is_outside():
    """With the sun on its upper side a level link droops; heated from below it rises."""
    assert growth(0.0, section=TUBE, material=STEEL, temperature_difference=5.0, up="z")[5] < 0
    assert growth(0.0, section=TUBE, material=STEEL, temperature_difference=5.0, up="-z")[5] > 0


@pytest.mark.parametrize("ratio", [0.999, 0.5, 0.2, 3.0])
def test_a_tapered_link_bends_more_where_it_is_thin(ratio: float):
    """The curvature follows 1 / height along a taper: the slope of the tip is expansion x
    difference x length x ln(ratio) / (height (ratio - 1)).
    """
    root = 0.08
    stations = [
        {"at": at, "section": {"kind": "rod", "diameter": d}}
        for at, d in ((0.0, root), (LENGTH, root * ratio))
    ]
    found = growth(
        0.0,
        section={"kind": "tapered", "stations": stations},
        material=STEEL,
        temperature_difference=10.0,
        up="z",
    )
    slope = 12e-6 * 10 * LENGTH * math.log(ratio) / (root * (ratio - 1))
    assert found[1] == pytest.approx(slope, rel=1e-9)
    # The deflection is the integral of curvature x distance from the tip.
    lever = (ratio * math.log(ratio) - ratio + 1) / (ratio - 1) ** 2
    assert -found[5] == pytest.approx(12e-6 * 10 * LENGTH**2 / root * lever, rel=1e-6)


def strip(
    below: dict[str, float], above: dict[str, float], thick: tuple[float, float], line: float
) -> dict[str, object]:
    """Return the section of two bonded strips, the contact of which lies `line` (m) above the
    link's line.
    """
    layers = [
        {
            "section": {"kind": "rectangle", "width": 0.01, "height": h},
            "material": material,
            "offset": offset,
        }
        for h, material, offset in (
            (thick[0], below, line - thick[0] / 2),
            (thick[1], above, line + thick[1] / 2),
        )
    ]
    return {"kind": "composite", "layers": layers}


@pytest.mark.parametrize("thick", [(1e-3, 1e-3), (1e-3, 3e-3), (2e-3, 0.5e-3)])
@pytest.mark.parametrize("line", [0.0, 4e-3])
def test_a_bimetal_bends_by_timoshenkos_formula(thick: tuple[float, float], line: float):
    """Curvature 6 (a2 - a1) dT (1 + m)^2 / (h (3 (1 + m)^2 + (1 + m n)(m^2 + 1/(m n)))), m the
    ratio of thicknesses, n that of the moduli.
    """
    rise = 40.0
    found = growth(rise, section=strip(STEEL, ALUMINIUM, thick, line), up="z")
    m, n = thick[0] / thick[1], 210e9 / 70e9
    below = sum(thick) * (3 * (1 + m) ** 2 + (1 + m * n) * (m**2 + 1 / (m * n)))
    curvature = 6 * (23e-6 - 12e-6) * rise * (1 + m) ** 2 / below
    assert found[1] == pytest.approx(curvature * LENGTH, rel=1e-9)
    assert -found[5] == pytest.approx(curvature * LENGTH**2 / 2, rel=1e-9)


def test_layers_of_one_expansion_stay_straight():
    """Bonded layers of one expansion grow as one, wherever their centroids lie and however stiff
    they are.
    """
    stiff = {**STEEL, "expansion": 23e-6}
    found = growth(15.0, section=strip(stiff, ALUMINIUM, (1e-3, 2e-3), 1e-3))
    np.testing.assert_allclose(found, [0, 0, 0, 23e-6 * 15 * LENGTH, 0, 0], rtol=1e-9, atol=1e-15)


def test_a_sleeve_restrains_its_tube():
    """Concentric layers grow by the mean of their expansions, weighted with Young's modulus x
    area.
    """
    outer, inner = (
        {"kind": "tube", "outer": 0.06, "wall": 0.002},
        {"kind": "tube", "outer": 0.056, "wall": 0.003},
    )
    layers = [{"section": outer, "material": STEEL}, {"section": inner, "material": ALUMINIUM}]
    found = growth(10.0, section={"kind": "composite", "layers": layers})
    of_steel, of_aluminium = 210e9 * (0.06**2 - 0.056**2), 70e9 * (0.056**2 - 0.05**2)
    mean = (12e-6 * of_steel + 23e-6 * of_aluminium) / (of_steel + of_aluminium)
    np.testing.assert_allclose(found, [0, 0, 0, mean * 10 * LENGTH, 0, 0], rtol=1e-9, atol=1e-15)


def test_a_sandwich_bends_by_steiners_theorem():
    """Two sheets at a distance: each adds Young's modulus x (own second moment + area x offset
    squared).
    """
    sheet, offset = {"kind": "rectangle", "width": 0.05, "height": 2e-3}, 0.02
    layers = [{"section": sheet, "material": STEEL, "offset": sign * offset} for sign in (-1, 1)]
    link = ElasticLink(Link(length=LENGTH, section=Composite(layers=layers), up="z"), AXIS)
    second = 2 * (0.05 * 2e-3**3 / 12 + 0.05 * 2e-3 * offset**2)
    assert link.tip_compliance[1, 1] == pytest.approx(LENGTH / (210e9 * second), rel=1e-9)
    assert link.tip_compliance[3, 3] == pytest.approx(LENGTH / (210e9 * 2 * 0.05 * 2e-3), rel=1e-9)


@pytest.mark.parametrize(
    "fields",
    [
        {"rigid": True},
        {
            "section": TUBE,
            "material": {key: value for key, value in STEEL.items() if key != "expansion"},
        },
        {
            "section": {"kind": "custom", "area": 5e-4, "i_y": 2e-7, "i_z": 2e-7, "torsion": 4e-7},
            "material": STEEL,
        },
    ],
)
def test_a_difference_across_an_unknown_section_is_refused(fields: dict[str, object]):
    """A difference is refused where height or expansion of the section are not known: its effect
    could not be computed.
    """
    with pytest.raises(
        ValidationError, match="temperature_difference of a link whose bending by it is not known"
    ):
        Link(length=LENGTH, temperature_difference="5 K", **fields)


OF_NU212 = {
    "bore": 0.06,
    "outside_diameter": 0.11,
    "rollers": 14,
    "roller_diameter": 0.014,
    "roller_length": 0.014,
    "pitch_diameter": 0.0855,
    "span": 0.08,
    "clearance": "50 µm",
    "finish": "turned",
}


def test_a_warm_inner_ring_takes_clearance():
    """NU212 with its inner ring 10 K above the outer: 12.5e-6/K x 10 K x (3 x 110 + 60)/4 mm = 12.2
    µm less; 50 K leave a preload.
    """
    for difference in (10.0, 50.0):
        found = RollerPair(**OF_NU212, inner_ring_warmer=difference).working.nominal
        assert found == pytest.approx(50e-6 - 12.5e-6 * difference * 97.5e-3, rel=1e-12)
    assert found < 0


def test_an_aluminium_housing_loosens_as_it_warms():
    """The interference of the outer ring falls by (23 - 12.5)e-6/K x 30 K x 110 mm = 34.65 µm; 80 %
    of that, flattened seats aside, is clearance.
    """
    pair = RollerPair(**OF_NU212, housing_interference="60 µm", housing_expansion=23e-6)
    kept = 110 / (110 + 3)
    assert pair.working.nominal == pytest.approx(50e-6 - 0.8 * 60e-6 * kept, rel=1e-12)
    for rise, tight in ((30.0, 60e-6 - 34.65e-6), (-10.0, 60e-6 + 11.55e-6), (80.0, 0.0)):
        assert pair.warmed(Toleranced(rise)).working.nominal == pytest.approx(
            50e-6 - 0.8 * tight * kept, rel=1e-12
        ), rise


def test_an_aluminium_shaft_takes_clearance_as_it_warms():
    """A shaft that expands more than its inner ring tightens its fit by 10.5e-6/K x 30 K x 60 mm;
    every simulated bearing loses the same.
    """
    pair = RollerPair(**OF_NU212, shaft_interference="20 µm ± 5 µm", shaft_expansion=23e-6)
    warm = pair.warmed(Toleranced(30.0))
    lost = 0.8 * 10.5e-6 * 30 * 0.06 * 60 / (60 + 3)
    assert pair.working.nominal - warm.working.nominal == pytest.approx(lost, rel=1e-9)
    assert warm.working.tolerance == pytest.approx(pair.working.tolerance, rel=1e-9)
    np.testing.assert_allclose(
        pair.sample(50, 1)["working"] - warm.sample(50, 1)["working"], lost, rtol=1e-6
    )
    np.testing.assert_array_equal(pair.sample(50, 1)["mounted"], warm.sample(50, 1)["mounted"])


def test_a_bearing_all_of_steel_keeps_its_fits():
    """Where shaft, rings and housing expand as one, and where the bearing states its own
    temperature, that of the arm changes nothing.
    """
    steel = RollerPair(**OF_NU212, shaft_interference="20 µm")
    own = RollerPair(
        **OF_NU212, shaft_interference="20 µm", shaft_expansion=23e-6, temperature_rise="5 K"
    )
    for pair in (steel, own):
        assert pair.warmed(Toleranced(40.0)) is pair
        assert pair.warmed(None) is pair
    assert own.working.nominal == pytest.approx(
        steel.working.nominal - 0.8 * 10.5e-6 * 5 * 0.06 * 60 / 63, rel=1e-9
    )


def test_the_play_of_a_joint_grows_with_its_clearance():
    """The terms of a drawn bearing in a warm arm are those of a bearing with its warm clearance."""
    fits = {**OF_NU212, "housing_interference": "60 µm", "housing_expansion": 23e-6}
    turn = np.eye(6)[2]
    warm = RollerPair(**fits).terms(Motion(turn, rise=Toleranced(30.0)))
    stated = RollerPair(**fits, temperature_rise="30 K").terms(Motion(turn))
    assert [(term.name, term.scale) for term in warm] == [
        (term.name, term.scale) for term in stated
    ]
    cold = RollerPair(**fits).terms(Motion(turn))
    free = "inboard clearance position 1"
    scales = [next(term.scale for term in terms if term.name == free) for terms in (warm, cold)]
    assert scales[0] - scales[1] == pytest.approx(0.8 * 34.65e-6 * 110 / 113 / 2, rel=1e-9)


def test_a_bearing_beyond_its_law_at_temperature_is_refused():
    """A clearance that is valid on the bench and beyond the validity of the contact law in the cold
    names the joint and the clearance there.
    """
    bearing = {
        **OF_NU212,
        "kind": "roller pair",
        "housing_interference": "60 µm",
        "housing_expansion": 300e-6,
        "clearance": "0 µm",
    }
    joint = {
        "name": "A",
        "type": "revolute",
        "limits": (-1, 1),
        "bearing": bearing,
        "link": {"length": 1.0},
    }
    Arm.model_validate({"name": "bench", "joints": [joint]})
    with pytest.raises(ValidationError, match="at the temperature of the arm"):
        Arm.model_validate(
            {"name": "cold", "joints": [joint], "environment": {"temperature": "-20 °C"}}
        )


def test_the_clearance_of_a_warm_bearing_changes_by_its_expansions():
    """Per kelvin a tight aluminium housing gives 80 % of 10.5e-6/K x 110 mm, less what seats
    flatten; a loose one, and one all of steel, nothing.
    """
    kept = 110 / (110 + 3)
    tight = RollerPair(**OF_NU212, housing_interference="60 µm", housing_expansion=23e-6)
    found = [tight.clearance_per_kelvin(Toleranced(rise, 10.0)) for rise in (0.0, 20.0, 35.0, 80.0)]
    assert found[:3] == [pytest.approx(0.8 * 10.5e-6 * 0.11 * kept, rel=1e-9)] * 3
    assert found[3] == 0
    assert (
        RollerPair(**OF_NU212, shaft_interference="20 µm").clearance_per_kelvin(
            Toleranced(20.0, 10.0)
        )
        == 0
    )
    own = RollerPair(
        **OF_NU212, housing_interference="60 µm", housing_expansion=23e-6, temperature_rise="5 K"
    )
    assert own.clearance_per_kelvin(Toleranced(20.0, 10.0)) == 0
    assert tight.clearance_per_kelvin(Toleranced(20.0)) == 0
