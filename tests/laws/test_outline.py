"""Sections by their outline: sectionproperties against the closed forms, in both directions."""

from __future__ import annotations

import numpy as np
import pytest

from lostmotion.laws import outline
from lostmotion.laws.cross_sections import (
    SectionValues,
    box_section,
    i_section,
    rectangle_section,
    round_section,
)
from lostmotion.parts.elastic_link import ElasticLink
from lostmotion.parts.link import Link
from tests.parts.conditions import STEEL

# A row of docs/validation.md each: quantity, compared with, agreement, other files.
VALIDATES = (
    (
        "sections",
        "finite elements of sectionproperties: area, second moments, torsion",
        "0.1 % (I torsion 0.5 %)",
        "laws/outline.py",
    ),
)

if not outline.available():
    pytest.skip(
        'sectionproperties is not installed: pip install "lostmotion[sections]"',
        allow_module_level=True,
    )


def rectangle(width: float, height: float) -> outline.Points:
    """Return the corners of a rectangle about the origin."""
    return (
        (-width / 2, -height / 2),
        (width / 2, -height / 2),
        (width / 2, height / 2),
        (-width / 2, height / 2),
    )


def circle(diameter: float, corners: int = 180) -> outline.Points:
    """Return the corners of a polygon of the same area as a circle."""
    angle = np.arange(corners) * 2 * np.pi / corners
    radius = diameter / 2 * np.sqrt(2 * np.pi / corners / np.sin(2 * np.pi / corners))
    return tuple(
        zip((radius * np.cos(angle)).tolist(), (radius * np.sin(angle)).tolist(), strict=True)
    )


def i_outline(w: float, h: float, web: float, flange: float) -> outline.Points:
    """Return the corners of an I-section."""
    right = [
        (w / 2, -h / 2),
        (w / 2, flange - h / 2),
        (web / 2, flange - h / 2),
        (web / 2, h / 2 - flange),
        (w / 2, h / 2 - flange),
        (w / 2, h / 2),
    ]
    return (*right, *((-y, z) for y, z in reversed(right)))


CASES: dict[str, tuple[SectionValues, tuple[outline.Points, tuple[outline.Points, ...]]]] = {
    "bar": (rectangle_section(0.02, 0.05, 0.3), (rectangle(0.02, 0.05), ())),
    "rod": (round_section(0.04, 0.0, 0.3), (circle(0.04), ())),
    "tube": (round_section(0.06, 0.048, 0.3), (circle(0.06), (circle(0.048),))),
    "box": (
        box_section(0.04, 0.06, 0.004, 0.3),
        (rectangle(0.04, 0.06), (rectangle(0.032, 0.052),)),
    ),
    "thick box": (
        box_section(0.05, 0.05, 0.012, 0.3),
        (rectangle(0.05, 0.05), (rectangle(0.026, 0.026),)),
    ),
    "I": (i_section(0.06, 0.1, 0.004, 0.006, 0.3), (i_outline(0.06, 0.1, 0.004, 0.006), ())),
}


@pytest.mark.parametrize("name", CASES)
def test_closed_forms_are_those_of_finite_elements(name: str):
    """Area, second moments and torsion agree to 0.1 % (I torsion 0.5 %); shear factors are defined
    differently and agree within 10 %.
    """
    ours, (points, holes) = CASES[name]
    found = outline.outline_section(points, holes, 0.3)
    for field in ("area", "i_y", "i_z"):
        assert getattr(ours, field) == pytest.approx(getattr(found, field), rel=1e-3), field
    assert ours.torsion == pytest.approx(found.torsion, rel=5e-3 if name == "I" else 1e-3)
    if name in {"rod", "box"}:
        assert ours.shear_z == pytest.approx(found.shear_z, rel=0.1)
    assert abs(found.i_yz) < 1e-4 * found.i_y
    assert max(abs(found.centre_y), abs(found.centre_z)) < 1e-4 * np.sqrt(found.area)


def test_properties_rotate_with_the_section():
    """Rotated by 30 degrees a bar has the transformed products of inertia and of shear; its
    position does not matter.
    """
    turn = np.array([[np.cos(0.5), -np.sin(0.5)], [np.sin(0.5), np.cos(0.5)]])
    straight = outline.outline_section(rectangle(0.04, 0.015), (), 0.3)
    moved = tuple(map(tuple, (np.array(rectangle(0.04, 0.015)) @ turn.T + [0.3, -0.2]).tolist()))
    turned = outline.outline_section(moved, (), 0.3)
    second = turn @ np.diag([straight.i_z, straight.i_y]) @ turn.T
    np.testing.assert_allclose(
        [turned.i_z, turned.i_yz, turned.i_y], second[[0, 0, 1], [0, 1, 1]], rtol=1e-9
    )
    shear = turn @ np.diag([1 / straight.shear_y, 1 / straight.shear_z]) @ turn.T
    np.testing.assert_allclose(
        [1 / turned.shear_y, turned.shear_yz, 1 / turned.shear_z],
        shear[[0, 0, 1], [0, 1, 1]],
        rtol=1e-3,
    )


def test_a_thin_channel_has_its_shear_centre_outside():
    """A thin channel's shear centre is 3 b^2/(h + 6 b) behind the middle of its web (b, h to the
    middles of the walls).
    """
    b, h, t = 0.04, 0.06, 0.0015
    points = ((0, 0), (b, 0), (b, t), (t, t), (t, h - t), (b, h - t), (b, h), (0, h))
    found = outline.outline_section(points, (), 0.0)
    mid_b, mid_h = b - t / 2, h - t
    centroid = (2 * b * t * b / 2 + (h - 2 * t) * t * t / 2) / (2 * b * t + (h - 2 * t) * t)
    assert t / 2 - 3 * mid_b**2 / (mid_h + 6 * mid_b) - centroid == pytest.approx(
        found.centre_y, rel=0.01
    )
    assert abs(found.centre_z) < 1e-5


def test_a_link_may_have_an_outline():
    """A link with the outline of a rectangular bar bends as that bar does; an outline whose sides
    cross is refused.
    """
    fields = {"length": 0.5, "material": STEEL}
    by_corners = ElasticLink(
        Link(**fields, section={"kind": "outline", "points": rectangle(0.02, 0.05)}),
        np.array([0, 1.0, 0]),
    ).tip_compliance
    bar = ElasticLink(
        Link(**fields, section={"kind": "rectangle", "width": 0.02, "height": 0.05}),
        np.array([0, 1.0, 0]),
    ).tip_compliance
    np.testing.assert_allclose(by_corners[:3, :3], bar[:3, :3], rtol=1e-3, atol=1e-12)
    with pytest.raises(ValueError, match="an invalid outline: Self-intersection"):
        Link(
            **fields,
            section={"kind": "outline", "points": ((0, 0), (0.1, 0.1), (0.1, 0), (0, 0.1))},
        )
    with pytest.raises(ValueError, match="an invalid outline: Hole lies outside"):
        Link(
            **fields,
            section={
                "kind": "outline",
                "points": rectangle(0.02, 0.05),
                "holes": [((1, 1), (2, 1), (1, 2))],
            },
        )


def test_without_the_package_the_message_states_what_is_missing(monkeypatch: pytest.MonkeyPatch):
    """Without the package one message states what to install."""
    monkeypatch.setattr(outline, "available", lambda: False)
    with pytest.raises(ValueError, match="sectionproperties, which is not installed"):
        Link(
            length=0.5, material=STEEL, section={"kind": "outline", "points": rectangle(0.02, 0.05)}
        )
