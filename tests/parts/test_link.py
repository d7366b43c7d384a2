"""Links as cantilevers: what the tool does under tip weight and own weight, against closed
forms.
"""

from __future__ import annotations

import math

import numpy as np
import pytest
from pydantic import ValidationError

from lostmotion.laws.cross_sections import box_section, rectangle_section, round_section
from lostmotion.mechanism.arm import Arm
from lostmotion.mechanism.tool import Payload
from lostmotion.parts.elastic_link import ElasticLink
from lostmotion.parts.joint import FixedJoint, RevoluteJoint
from lostmotion.parts.link import Frame, Link
from lostmotion.spatial import inverse, pose_of
from lostmotion.units import Toleranced
from tests.parts.conditions import STEEL, at_tool

G0 = 9.80665
LENGTH, WIDTH, HEIGHT = 0.8, 0.03, 0.05
AREA, I_UPRIGHT, I_FLAT = WIDTH * HEIGHT, WIDTH * HEIGHT**3 / 12, HEIGHT * WIDTH**3 / 12
E, SHEAR = 210e9, 210e9 / 2.6
SHEAR_FACTOR = 13 / 15.3
BAR = {"kind": "rectangle", "width": WIDTH, "height": HEIGHT}
WEIGHTLESS = {**STEEL, "density": 1e-9}


def tip_error(
    *,
    q: float = 0.0,
    axis: str = "y",
    payload: Payload | None = None,
    names: tuple[str, ...] = (),
    **link: object,
) -> np.ndarray:
    """Return the design error (6,) of the tool at the end of one link on one joint, in the base's
    axes.
    """
    fields = {"length": LENGTH, "section": BAR, "material": STEEL, **link}
    arm = Arm(
        name="arm",
        joints=[RevoluteJoint(name="A", limits=(-4, 4), axis=axis, link=fields)],
        payload=payload or Payload(),
    )
    found = [(item.term, twist) for item, twist in at_tool(arm, [q])]
    return sum(
        (
            twist
            for term, twist in found
            if term.level == "design" and (not names or term.name in names)
        ),
        np.zeros(6),
    )


def test_a_tip_weight_bends_a_horizontal_cantilever():
    """A weight F on the tip of a weightless bar lowers it by F l^3/(3 E I) + F l/(k G A) and tips
    it down by F l^2/(2 E I).
    """
    force = 5 * G0
    error = tip_error(payload=Payload(mass=5.0), material=WEIGHTLESS)
    assert error[5] == pytest.approx(
        -(force * LENGTH**3 / (3 * E * I_UPRIGHT) + force * LENGTH / (SHEAR_FACTOR * SHEAR * AREA)),
        rel=1e-9,
    )
    assert error[1] == pytest.approx(force * LENGTH**2 / (2 * E * I_UPRIGHT), rel=1e-9)
    np.testing.assert_allclose(error[[0, 2, 3, 4]], 0, atol=1e-18)


def test_a_bar_sags_under_its_own_weight():
    """Steel's own weight w per length lowers the tip by w l^4/(8 E I) + w l^2/(2 k G A) and tips it
    down by w l^3/(6 E I).
    """
    w = AREA * 7850 * G0
    error = tip_error()
    assert error[5] == pytest.approx(
        -(w * LENGTH**4 / (8 * E * I_UPRIGHT) + w * LENGTH**2 / (2 * SHEAR_FACTOR * SHEAR * AREA)),
        rel=1e-9,
    )
    assert error[1] == pytest.approx(w * LENGTH**3 / (6 * E * I_UPRIGHT), rel=1e-9)
    np.testing.assert_allclose(error[[0, 2, 3, 4]], 0, atol=1e-18)


def test_a_stated_mass_is_spread_as_the_bars_own_was():
    """A link of stated mass sags as a bar of that weight per length, whatever its density."""
    assert tip_error(mass=4.0)[5] == pytest.approx(
        tip_error()[5] * 4.0 / (AREA * LENGTH * 7850), rel=1e-9
    )


def test_a_centre_of_mass_half_way_is_that_of_an_even_bar():
    """A centre of mass stated where it would be anyway changes nothing, whichever way gravity
    points.
    """
    for q in (0.0, 0.7, math.pi / 2):
        np.testing.assert_allclose(
            tip_error(q=q, mass=4.0, centre_of_mass=(LENGTH / 2, 0, 0)),
            tip_error(q=q, mass=4.0),
            rtol=1e-12,
            atol=1e-20,
        )


@pytest.mark.parametrize("share", [0.05, 0.3, 0.5, 0.62, 0.97])
def test_a_weight_is_spread_evenly_about_its_centre(share: float):
    """Tip deflection and slope are the sums of P x^2 (3 l - x)/(6 E I) + P x/(k G A) and P x^2/(2 E
    I) over the span that the weight covers.
    """
    centre, force, points = share * LENGTH, 4 * G0, 200_000
    half = min(centre, LENGTH - centre)
    x = centre + half * (2 * (np.arange(points) + 0.5) / points - 1)
    error = tip_error(mass=4.0, centre_of_mass=(centre, 0, 0))
    deflection = force * np.mean(
        x**2 * (3 * LENGTH - x) / (6 * E * I_UPRIGHT) + x / (SHEAR_FACTOR * SHEAR * AREA)
    )
    assert error[5] == pytest.approx(-deflection, rel=1e-9)
    assert error[1] == pytest.approx(force * np.mean(x**2) / (2 * E * I_UPRIGHT), rel=1e-9)


def test_a_weight_beside_a_raised_link_bends_it_all_along_its_span():
    """Under gravity along the link a mass b beside it bends it by the sums of P b x (2 l - x)/(2 E
    I) and P b x/(E I).
    """
    centre, b, force, points = 0.3 * LENGTH, 0.1, 4 * G0, 200_000
    x = 2 * centre * (np.arange(points) + 0.5) / points
    names = ("sag under own weight",)
    error = tip_error(q=-math.pi / 2, mass=4.0, centre_of_mass=(centre, 0, b), names=names)
    assert error[1] == pytest.approx(-force * b * centre / (E * I_UPRIGHT), rel=1e-9)
    assert abs(error[3]) == pytest.approx(
        force * b * np.mean(x * (2 * LENGTH - x)) / (2 * E * I_UPRIGHT), rel=1e-9
    )


def test_a_weight_at_an_end_is_a_point():
    """The nearer the centre to an end, the more the weight is a point there: at the tip it bends as
    a payload does, and no step lies between.
    """
    at_tip = tip_error(mass=4.0, centre_of_mass=(LENGTH, 0, 0))
    np.testing.assert_allclose(
        at_tip, tip_error(material=WEIGHTLESS, payload=Payload(mass=4.0)), rtol=1e-8, atol=1e-15
    )
    for end in (0.0, LENGTH / 2, LENGTH):
        before, after = (
            tip_error(mass=4.0, centre_of_mass=(end + step, 0, 0), names=("sag under own weight",))
            for step in (-1e-9, 1e-9)
        )
        np.testing.assert_allclose(before, after, atol=1e-12)


def test_a_mass_beside_the_link_twists_it():
    """A mass held b to the side of half length twists the link by P b a/(G J) about its length,
    beside bending it.
    """
    a, b, force = LENGTH / 2, 0.1, 4 * G0
    straight = tip_error(mass=4.0, centre_of_mass=(a, 0, 0))
    beside = tip_error(mass=4.0, centre_of_mass=(a, b, 0))
    torsion = rectangle_section(WIDTH, HEIGHT, 0.3).torsion
    assert beside[0] == pytest.approx(-force * b * a / (SHEAR * torsion), rel=1e-9)
    np.testing.assert_allclose(np.delete(beside - straight, 0), 0, atol=1e-15)


def test_a_mass_beyond_the_tip_bends_it_as_force_and_moment():
    """A mass that hangs c beyond the tip acts there as its weight and as weight times c; one behind
    the joint bends nothing.
    """
    c, force = 0.2, 4 * G0
    error = tip_error(mass=4.0, centre_of_mass=(LENGTH + c, 0, 0), names=("sag under own weight",))
    bending = force * LENGTH**3 / (3 * E * I_UPRIGHT) + force * c * LENGTH**2 / (2 * E * I_UPRIGHT)
    assert error[5] == pytest.approx(
        -(bending + force * LENGTH / (SHEAR_FACTOR * SHEAR * AREA)), rel=1e-9
    )
    assert error[1] == pytest.approx(
        force * LENGTH**2 / (2 * E * I_UPRIGHT) + force * c * LENGTH / (E * I_UPRIGHT), rel=1e-9
    )
    assert not tip_error(mass=4.0, centre_of_mass=(-0.1, 0, 0)).any()


@pytest.mark.parametrize("q", [0.0, 0.5, 1.2, math.pi / 2, 2.5, -0.8])
def test_only_the_load_across_a_link_bends_it(q: float):
    """A link raised by an angle bends by the cosine of it across its length and shortens by the
    sine along it.
    """
    force = 5 * G0
    # about +y a positive angle points down
    error = tip_error(q=-q, payload=Payload(mass=5.0), material=WEIGHTLESS)
    along, up = np.array([math.cos(q), 0, math.sin(q)]), np.array([-math.sin(q), 0, math.cos(q)])
    bending = LENGTH**3 / (3 * E * I_UPRIGHT) + LENGTH / (SHEAR_FACTOR * SHEAR * AREA)
    assert error[3:] @ up == pytest.approx(-force * math.cos(q) * bending, abs=1e-12)
    assert error[3:] @ along == pytest.approx(-force * math.sin(q) * LENGTH / (E * AREA), abs=1e-12)


def test_a_section_stands_upright_on_a_lifting_joint():
    """A section's width lies along its joint's axis: on a lifting joint (axis y) the bar stands
    upright, turned on its side it is softer.
    """
    upright = tip_error(payload=Payload(mass=5.0), material=WEIGHTLESS)
    flat = tip_error(payload=Payload(mass=5.0), material=WEIGHTLESS, up="y")
    assert flat[1] / upright[1] == pytest.approx(I_UPRIGHT / I_FLAT, rel=1e-9)
    # About a vertical axis the width stands up, so gravity bends the bar over its width.
    lying = tip_error(axis="z", payload=Payload(mass=5.0), material=WEIGHTLESS)
    assert lying[1] / upright[1] == pytest.approx(I_UPRIGHT / I_FLAT, rel=1e-9)


@pytest.mark.parametrize("direction", ["x", "-x", "z", (1.0, 0, 1.0)])
def test_up_or_axis_along_the_link_still_leaves_a_section(direction: str | tuple[float, ...]):
    """A link that its joint turns about its own length has no side of its own; any is chosen, and
    all terms stay finite.
    """
    error = tip_error(
        axis=direction,
        direction=direction,
        section={"kind": "rod", "diameter": 0.04},
        payload=Payload(mass=5.0),
    )
    assert np.isfinite(error).all()


def test_a_round_link_has_the_same_stiffness_in_all_directions():
    """A rod does not care which way its section lies."""
    rod = {"kind": "rod", "diameter": 0.04}
    load = Payload(mass=5.0, moment=(3.0, 4.0, 5.0))
    np.testing.assert_allclose(
        tip_error(section=rod, payload=load),
        tip_error(section=rod, payload=load, up=(0, 1, 3)),
        rtol=1e-9,
        atol=1e-18,
    )


def test_how_the_tip_frame_is_turned_does_not_matter():
    """A link that ends in a turned frame moves the tool as one that ends in a straight frame, if
    the tool is turned back.
    """
    rpy = (0.4, -1.1, 2.0)
    back = inverse(pose_of((0, 0, 0), rpy))
    roll, pitch, yaw = (
        math.atan2(back[2, 1], back[2, 2]),
        -math.asin(back[2, 0]),
        math.atan2(back[1, 0], back[0, 0]),
    )
    load = Payload(
        mass=3.0, centre_of_mass=(0.1, -0.2, 0.3), force=(10, 20, -30), moment=(1, -2, 3)
    )

    def error(turned: tuple[float, float, float], tool: tuple[float, float, float]) -> np.ndarray:
        link = Link(
            tip=Frame(xyz=(0.5, 0.2, 0.3), rpy=turned),
            section=BAR,
            material=STEEL,
            mass=2.0,
            centre_of_mass=(0.1, 0.1, 0.0),
        )
        arm = Arm(
            name="arm",
            joints=[RevoluteJoint(name="A", limits=(-4, 4), axis="y", link=link)],
            tool={"frame": {"rpy": tool}},
            payload=load,
        )
        return sum((twist for _, twist in at_tool(arm, [0.3])), np.zeros(6))

    np.testing.assert_allclose(
        error(rpy, (roll, pitch, yaw)), error((0, 0, 0), (0, 0, 0)), rtol=1e-9, atol=1e-18
    )


def test_two_half_links_in_line_bend_as_one():
    """A bar cut in two and welded again (a fixed joint) bends under tip load and own weight as the
    whole bar does.
    """
    load = Payload(mass=3.0, force=(10, 20, -30), moment=(1, -2, 3))
    whole = tip_error(payload=load)
    half = {"length": LENGTH / 2, "section": BAR, "material": STEEL, "up": "z"}
    joints = [
        RevoluteJoint(name="A", limits=(-4, 4), axis="y", link=half),
        FixedJoint(name="W", link=half),
    ]
    welded = Arm(name="arm", joints=joints, payload=load)
    np.testing.assert_allclose(
        sum(twist for _, twist in at_tool(welded, [0.0])), whole, rtol=1e-9, atol=1e-18
    )


def test_a_link_cut_too_long_reaches_further():
    """A length of 400 mm ± 50 µm moves the tool along the link, once per robot, by at most 50 µm
    and turns nothing.
    """
    joints = [
        RevoluteJoint(
            name="A",
            limits=(-4, 4),
            axis="z",
            link={"length": Toleranced(0.4, 5e-5), "direction": "y"},
        )
    ]
    ((item, twist),) = at_tool(Arm(name="arm", joints=joints), [0.5])
    assert item.name == "joints.A.link.length"
    assert item.term.level == "robot"
    np.testing.assert_allclose(
        twist * item.term.bound,
        [0, 0, 0, -5e-5 * math.sin(0.5), 5e-5 * math.cos(0.5), 0],
        atol=1e-15,
    )


def test_a_tip_from_a_table_may_be_too_far_as_well():
    """A tip frame with a length tolerance errs along the straight line to it, however the frame
    there is turned.
    """
    tip = Frame(xyz=(0.3, 0.0, 0.4), rpy=(0.4, -1.1, 2.0))
    arm = Arm(
        name="arm",
        joints=[
            RevoluteJoint(
                name="A", limits=(-4, 4), axis="y", link={"tip": tip, "length_tolerance": 5e-5}
            )
        ],
    )
    ((item, twist),) = at_tool(arm, [0.0])
    np.testing.assert_allclose(twist * item.term.bound, [0, 0, 0, 3e-5, 0, 4e-5], atol=1e-15)


def test_soft_batches_bend_more():
    """With stiffness ± 5 % the bending of a robot's link differs from the nominal by at most 5
    %.
    """
    material = {**STEEL, "scatter": 0.05}
    arm = Arm(
        name="arm",
        joints=[
            RevoluteJoint(
                name="A",
                limits=(-4, 4),
                axis="y",
                link={"length": LENGTH, "section": BAR, "material": material},
            )
        ],
        payload={"mass": 5},
    )
    found = {item.term.name: (item.term, twist) for item, twist in at_tool(arm, [0.0])}
    bent = found["bending under load"][1] + found["sag under own weight"][1]
    term, scatter = found["stiffness scatter"]
    np.testing.assert_allclose(scatter * term.bound, 0.05 * bent, rtol=1e-12)
    assert term.level == "robot"


def test_a_rigid_link_does_not_bend():
    """A link without a section carries any load without moving; its length is still as cut."""
    assert not tip_error(section=None, material=None, mass=100.0, payload=Payload(mass=500.0)).any()
    link = Link(length=0.4)
    assert link.total_mass == 0
    with pytest.raises(ValueError, match="rigid link"):
        _ = ElasticLink(link, np.array([0, 0, 1.0])).tip_compliance


def test_a_link_weighs_its_metal():
    """A 60 x 3 mm aluminium tube of 0.5 m weighs area x length x density, half way along."""
    tube = {"kind": "tube", "outer": 0.06, "wall": 0.003}
    link = Link(
        length=0.5, section=tube, material={"young": 70e9, "poisson": 0.33, "density": 2700.0}
    )
    assert link.total_mass == pytest.approx(math.pi * 0.057 * 0.003 * 0.5 * 2700, rel=1e-12)
    np.testing.assert_allclose(link.mass_centre, [0.25, 0, 0])
    assert Link(length=0.5, section=tube, material=STEEL, mass=7.0).total_mass == 7.0


@pytest.mark.parametrize(
    ("section", "expected"),
    [
        ({"kind": "tube", "outer": 0.06, "wall": 0.003}, round_section(0.06, 0.054, 0.3)),
        ({"kind": "rod", "diameter": 0.06}, round_section(0.06, 0.0, 0.3)),
        ({"kind": "rectangle", "width": 0.02, "height": 0.05}, rectangle_section(0.02, 0.05, 0.3)),
        (
            {"kind": "box", "width": 0.04, "height": 0.05, "wall": 0.003},
            box_section(0.04, 0.05, 0.003, 0.3),
        ),
    ],
)
def test_sections_hand_their_sizes_to_the_law(section: dict[str, object], expected: object):
    """Each kind of section gives the beam what its law says for its outer size and wall."""
    link = Link(length=1.0, section=section, material=STEEL)
    assert link.section is not None
    assert link.section.values(0.3) == expected


def test_any_section_can_be_given_by_its_figures():
    """A custom section bends by its own second moments: y along the joint's axis, z across."""
    custom = {
        "kind": "custom",
        "area": AREA,
        "i_y": I_UPRIGHT,
        "i_z": I_FLAT,
        "torsion": 1e-7,
        "shear_y": SHEAR_FACTOR,
        "shear_z": SHEAR_FACTOR,
    }
    load = Payload(mass=5.0)
    np.testing.assert_allclose(
        tip_error(section=custom, payload=load), tip_error(payload=load), rtol=1e-9, atol=1e-18
    )


@pytest.mark.parametrize(
    ("fields", "why"),
    [
        ({"length": 0.4, "tip": {"xyz": (0.4, 0, 0)}}, "both tip and length"),
        ({"length": Toleranced(0.4, 1e-4), "length_tolerance": 1e-4}, "a tolerance both in"),
        ({"length_tolerance": 1e-4}, "zero length"),
        ({"length": 0.4, "section": BAR}, "a section without a material"),
        ({"length": 0.4, "material": STEEL}, "a material without a section"),
        ({"length": 0.4, "direction": (0, 0, 0)}, "not zero"),
        ({"length": 0.4, "direction": (0, math.inf, 0)}, "not zero"),
        ({"length": 0.4, "up": (0, 0, 0)}, "not zero"),
        ({"length": 0.4, "up": "x"}, "up along the link"),
        ({"length": 0.4, "up": "-x"}, "up along the link"),
        ({"length": 0.4, "direction": (1, 2, 3), "up": (2, 4, 6)}, "up along the link"),
        (
            {
                "length": 0.4,
                "section": {"kind": "tube", "outer": 0.06, "wall": 0.031},
                "material": STEEL,
            },
            "wall 31 mm",
        ),
        (
            {
                "length": 0.4,
                "section": {"kind": "box", "width": 0.06, "height": 0.04, "wall": 0.02},
                "material": STEEL,
            },
            "wall 20 mm",
        ),
        ({"length": 0.4, "mass": -1.0}, "out of range"),
        ({"length": 0.4, "section": BAR, "material": {**STEEL, "poisson": 0.6}}, "out of range"),
    ],
)
def test_a_link_that_cannot_be_is_refused(fields: dict[str, object], why: str):
    """Walls thicker than the part, directions that point nowhere and contradictions are refused
    with the reason.
    """
    with pytest.raises(ValidationError) as caught:
        Link(**fields)
    assert why in str(caught.value) + "".join(
        str(error.get("ctx", "")) for error in caught.value.errors()
    )


def test_a_tube_may_be_solid():
    """A tube whose wall reaches its middle is a rod."""
    solid = Link(length=1.0, section={"kind": "tube", "outer": 0.06, "wall": 0.03}, material=STEEL)
    assert solid.section is not None
    assert solid.section.values(0.3) == round_section(0.06, 0.0, 0.3)
