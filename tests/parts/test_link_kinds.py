"""Links of every description: tapered, stepped, of two materials, by a matrix, by a measurement."""

from __future__ import annotations

import math

import numpy as np
import pytest
from pydantic import ValidationError
from scipy.integrate import quad

from lostmotion.laws.cross_sections import (
    box_section,
    compliance_per_length,
    i_section,
    rectangle_section,
    round_section,
)
from lostmotion.parts.compliance import compliance_error
from lostmotion.parts.elastic_link import ElasticLink
from lostmotion.parts.link import Link
from tests.parts.conditions import STEEL, condition, terms_at

E, G = 210e9, 210e9 / 2.6
ALUMINIUM = {"young": 70e9, "poisson": 0.33, "density": 2700.0, "scatter": 0.03}
CARBON = {"young": 120e9, "poisson": 0.3, "density": 1600.0, "shear_modulus": 5e9, "scatter": 0.1}
AXIS = np.array([0, 1.0, 0])
LENGTH = 0.8


def compliance(**fields: object) -> np.ndarray:
    """Tip compliance of a link along x behind a joint about y: then beam, joint and tip axes are
    the same but for turns by right angles.
    """
    return ElasticLink(Link(**{"length": LENGTH, "material": STEEL, **fields}), AXIS).tip_compliance


def sag(**fields: object) -> np.ndarray:
    """Turn and shift of the same tip per gravity."""
    return ElasticLink(
        Link(**{"length": LENGTH, "material": STEEL, **fields}), AXIS
    ).own_weight_compliance


def cone(tip: float, root: float = 0.1) -> dict[str, object]:
    """Solid, from the diameter at the joint to that at the tip."""
    return tapered(
        *((at, {"kind": "rod", "diameter": d}) for at, d in ((0.0, root), (LENGTH, tip)))
    )


def tapered(*stations: tuple[float, dict[str, object]]) -> dict[str, object]:
    """Return a taper through these sections."""
    return {
        "kind": "tapered",
        "stations": [{"at": at, "section": section} for at, section in stations],
    }


@pytest.mark.parametrize("ratio", [0.999999, 0.7, 0.5, 0.3, 0.1, 0.02, 1.5, 4.0, 30.0])
def test_a_cone_bends_by_the_closed_forms(ratio: float):
    """A solid cone from D to d: F l^3/(3 E I) D/d, slope F l^2/(6 E I) (D/d)(2 + D/d), torsion by
    the third powers; 1e-9 throughout.
    """
    big, r = 0.1, 1 / ratio
    i = math.pi / 64 * big**4
    c = compliance(section=cone(big * ratio))
    shear = round_section(1.0, 0.0, 0.3).shear_y
    area = math.pi / 4 * big**2
    cubes = (1 + r + r**2) * r / 3
    assert c[5, 5] == pytest.approx(
        LENGTH**3 / (3 * E * i) * r + LENGTH / (shear * G * area) * r, rel=1e-9
    )
    assert -c[1, 5] == pytest.approx(LENGTH**2 / (6 * E * i) * r * (2 + r), rel=1e-9)
    assert c[1, 1] == pytest.approx(LENGTH / (E * i) * cubes, rel=1e-9)
    assert c[0, 0] == pytest.approx(LENGTH / (2 * G * i) * cubes, rel=1e-9)
    assert c[3, 3] == pytest.approx(LENGTH / (E * area) * r, rel=1e-9)
    assert Link(
        length=LENGTH, material=STEEL, section=cone(big * ratio)
    ).total_mass == pytest.approx(7850 * area * LENGTH * (1 + ratio + ratio**2) / 3, rel=1e-12)


@pytest.mark.parametrize("kind", ["tube", "box", "I", "rectangle"])
def test_a_taper_is_the_integral_of_its_sections(kind: str):
    """Deflection is the integral of s^2/(E I(s)) + 1/(k G A(s)), adaptively; mass, its centre and
    sag are integrals as well.
    """
    ends = {
        "tube": ({"outer": 0.12, "wall": 0.008}, {"outer": 0.04, "wall": 0.001}),
        "box": (
            {"width": 0.08, "height": 0.12, "wall": 0.006},
            {"width": 0.03, "height": 0.04, "wall": 0.002},
        ),
        "I": (
            {"width": 0.08, "height": 0.12, "web": 0.006, "flange": 0.01},
            {"width": 0.03, "height": 0.04, "web": 0.004, "flange": 0.003},
        ),
        "rectangle": ({"width": 0.02, "height": 0.1}, {"width": 0.03, "height": 0.03}),
    }[kind]
    section = {
        "kind": "tapered",
        "stations": [
            {"at": at, "section": {"kind": kind, **sizes}}
            for at, sizes in zip((0.0, LENGTH), ends, strict=True)
        ],
    }

    def at(x: float) -> object:
        sizes = {
            name: ends[0][name] + (ends[1][name] - ends[0][name]) * x / LENGTH for name in ends[0]
        }
        law = {"tube": lambda outer, wall: round_section(outer, outer - 2 * wall, 0.3)}.get(kind)
        return (
            law(**sizes)
            if law
            else {"box": box_section, "I": i_section, "rectangle": rectangle_section}[kind](
                *sizes.values(), 0.3
            )
        )

    def integral(f: object) -> float:
        return quad(f, 0, LENGTH, epsabs=0, epsrel=1e-11, limit=200)[0]

    deflection = integral(
        lambda x: (LENGTH - x) ** 2 / (E * at(x).i_y) + 1 / (at(x).shear_z * G * at(x).area)
    )
    assert compliance(section=section)[5, 5] == pytest.approx(deflection, rel=1e-9)
    mass = integral(lambda x: 7850 * at(x).area)
    link = Link(length=LENGTH, material=STEEL, section=section)
    assert link.total_mass == pytest.approx(mass, rel=1e-10)
    assert link.mass_centre[0] == pytest.approx(
        integral(lambda x: 7850 * at(x).area * x) / mass, rel=1e-9
    )
    slice_ = np.linspace(0, LENGTH, 1001)
    areas = np.array([at(x).area for x in slice_]) * 7850
    inertia, shear = (
        np.array([f(at(x)) for x in slice_])
        for f in (lambda v: E * v.i_y, lambda v: v.shear_z * G * v.area)
    )
    step = slice_[1]
    beyond = np.concatenate([np.cumsum(((areas[1:] + areas[:-1]) / 2 * step)[::-1])[::-1], [0.0]])
    moment = np.concatenate([np.cumsum(((beyond[1:] + beyond[:-1]) / 2 * step)[::-1])[::-1], [0.0]])
    fallen = np.trapezoid(moment * (LENGTH - slice_) / inertia + beyond / shear, slice_)
    # the sum by trapezia is not better
    assert sag(section=section)[5, 2] == pytest.approx(fallen, rel=1e-4)


def test_a_taper_without_taper_is_a_prism():
    """Equal stations, or equal steps, make the link of one section: compliance, sag, mass and
    centre.
    """
    tube = {"kind": "tube", "outer": 0.06, "wall": 0.003}
    stations = {
        "kind": "tapered",
        "stations": [{"at": at, "section": tube} for at in (0.0, 0.3, 0.3, LENGTH)],
    }
    steps = {
        "kind": "stepped",
        "steps": [{"length": length, "section": tube} for length in (0.1, 0.5, 0.2)],
    }
    for section in (stations, steps):
        np.testing.assert_allclose(
            compliance(section=section), compliance(section=tube), rtol=1e-12, atol=1e-22
        )
        np.testing.assert_allclose(sag(section=section), sag(section=tube), rtol=1e-12, atol=1e-22)
        for centre in ((0.2, 0.0, 0.0), (0.75, 0.1, 0.0), (0.8, 0.0, 0.0)):
            own = {"mass": 3.0, "centre_of_mass": centre}
            np.testing.assert_allclose(
                sag(section=section, **own), sag(section=tube, **own), rtol=1e-12, atol=1e-20
            )


def test_a_stepped_beam_bends_by_its_closed_form():
    """Steel I1 over a, I2 over b: tip force F moves it by F/(3 E) [((a+b)^3 - b^3)/I1 + b^3/I2],
    shear adding; its own weight piece by piece.
    """
    a, b = 0.5, 0.3
    thick, thin = ({"kind": "rod", "diameter": d} for d in (0.06, 0.03))
    section = {
        "kind": "stepped",
        "steps": [{"length": a, "section": thick}, {"length": b, "section": thin}],
    }
    i1, i2 = (math.pi / 64 * d**4 for d in (0.06, 0.03))
    a1, a2 = (math.pi / 4 * d**2 for d in (0.06, 0.03))
    k = round_section(1.0, 0.0, 0.3).shear_y
    assert compliance(section=section)[5, 5] == pytest.approx(
        (((a + b) ** 3 - b**3) / i1 + b**3 / i2) / (3 * E) + (a / a1 + b / a2) / (k * G), rel=1e-12
    )
    w1, w2 = 7850 * a1, 7850 * a2
    # at the step: the thick part under its own weight, the thin one's and its moment; beyond: slope
    # times b, and the thin part's own sag
    force, moment = w2 * b, w2 * b**2 / 2
    drop = (
        w1 * a**4 / (8 * E * i1)
        + force * a**3 / (3 * E * i1)
        + moment * a**2 / (2 * E * i1)
        + (w1 * a**2 / 2 + force * a) / (k * G * a1)
    )
    slope = w1 * a**3 / (6 * E * i1) + force * a**2 / (2 * E * i1) + moment * a / (E * i1)
    drop += slope * b + w2 * b**4 / (8 * E * i2) + w2 * b**2 / (2 * k * G * a2)
    assert sag(section=section)[5, 2] == pytest.approx(drop, rel=1e-12)
    link = Link(length=LENGTH, section=section, material=STEEL)
    assert link.total_mass == pytest.approx(w1 * a + w2 * b, rel=1e-12)
    assert link.mass_centre[0] == pytest.approx(
        (w1 * a * a / 2 + w2 * b * (a + b / 2)) / (w1 * a + w2 * b), rel=1e-12
    )


TUBE_IN_SLEEVE = {
    "kind": "composite",
    "layers": [
        {"section": {"kind": "tube", "outer": 0.05, "wall": 0.003}, "material": ALUMINIUM},
        {"section": {"kind": "tube", "outer": 0.054, "wall": 0.002}, "material": CARBON},
    ],
}


def test_a_tube_in_a_sleeve_is_as_stiff_as_both():
    """Bending, pull and torsion of two tubes bonded together: E I, E A and G J add; so does the
    mass.
    """
    c = compliance(section=TUBE_IN_SLEEVE, material=None)
    inner, outer = round_section(0.05, 0.044, 0.33), round_section(0.054, 0.05, 0.3)
    bend = 70e9 * inner.i_y + 120e9 * outer.i_y
    shear = inner.shear_y * 70e9 / 2.66 * inner.area + outer.shear_y * 5e9 * outer.area
    assert c[5, 5] == pytest.approx(LENGTH**3 / (3 * bend) + LENGTH / shear, rel=1e-12)
    assert c[1, 1] == pytest.approx(LENGTH / bend, rel=1e-12)
    assert c[0, 0] == pytest.approx(
        LENGTH / (70e9 / 2.66 * inner.torsion + 5e9 * outer.torsion), rel=1e-12
    )
    assert c[3, 3] == pytest.approx(LENGTH / (70e9 * inner.area + 120e9 * outer.area), rel=1e-12)
    assert Link(length=LENGTH, section=TUBE_IN_SLEEVE).total_mass == pytest.approx(
        LENGTH * (2700 * inner.area + 1600 * outer.area), rel=1e-12
    )


def test_each_material_scatters_for_itself():
    """The term of a material is what the tip does when that material alone is softer by its
    scatter: the derivative of the whole, by differences.
    """
    at = condition([3.0, -2, 5, 40, -70, 90])
    found = {
        term.name: term
        for term in terms_at(ElasticLink(Link(length=LENGTH, section=TUBE_IN_SLEEVE), AXIS), at)
    }
    for k, scatter in enumerate((0.03, 0.1)):
        moved = []
        for step in (-1e-5, 1e-5):
            layers = [dict(layer) for layer in TUBE_IN_SLEEVE["layers"]]
            soft = dict(layers[k]["material"])
            soft |= {
                "young": soft["young"] * (1 - step),
                "shear_modulus": soft.get("shear_modulus", soft["young"] / 2.66) * (1 - step),
            }
            layers[k]["material"] = soft
            link = Link(length=LENGTH, section={"kind": "composite", "layers": layers})
            moved.append(sum(term.screw for term in terms_at(ElasticLink(link, AXIS), at)[:2]))
        term = found[f"stiffness scatter of material {k + 1}"]
        np.testing.assert_allclose(
            term.screw * term.bound, (moved[1] - moved[0]) / 2e-5 * scatter, rtol=1e-6, atol=1e-14
        )


def test_one_batch_of_a_material_scatters_once():
    """Two steps of one material share their draw; a step of another material has its own."""
    rods = [{"kind": "rod", "diameter": d} for d in (0.05, 0.04, 0.03)]
    steps = [
        {"length": LENGTH / 4, "section": rods[0]},
        {"length": LENGTH / 4, "section": rods[1], "material": CARBON},
        {"length": LENGTH / 2, "section": rods[2]},
    ]
    link = ElasticLink(
        Link(length=LENGTH, section={"kind": "stepped", "steps": steps}, material=ALUMINIUM), AXIS
    )
    found = [
        term for term in terms_at(link, condition([0, 0, 0, 0, 0, 10.0])) if term.robot is not None
    ]
    assert [term.name for term in found] == [
        "stiffness scatter of material 1",
        "stiffness scatter of material 2",
    ]


def random_link(rng: np.random.Generator) -> Link:
    """Draw a link of any kind of section, prismatic or not, of one material or several, in any
    direction.
    """

    def sized(kind: str) -> dict[str, object]:
        a, b = rng.uniform(0.02, 0.2, 2)
        t = rng.uniform(0.05, 0.45) * min(a, b)
        sizes = {
            "tube": {"outer": a, "wall": t},
            "rod": {"diameter": a},
            "rectangle": {"width": a, "height": b},
            "box": {"width": a, "height": b, "wall": t},
            "I": {"width": a, "height": b, "web": t, "flange": t},
        }[kind]
        return {"kind": kind, **sizes}

    def anything() -> dict[str, object]:
        return sized(("tube", "rod", "rectangle", "box", "I")[rng.integers(5)])

    def material() -> dict[str, float]:
        young = 10 ** rng.uniform(9, 11.5)
        return {
            "young": young,
            "poisson": 0.3,
            "density": 2000.0,
            "shear_modulus": young * rng.uniform(0.03, 1.0),
        }

    tip = {"xyz": rng.normal(size=3) * 10 ** rng.uniform(-1.5, 0.5), "rpy": rng.uniform(-3, 3, 3)}
    reach = float(np.linalg.norm(tip["xyz"]))
    made = rng.integers(4)
    if made == 0:
        return Link(tip=tip, section=anything(), material=material())
    if made == 1:
        layers = [
            {"section": anything(), "material": material()} for _ in range(rng.integers(1, 4))
        ]
        return Link(tip=tip, section={"kind": "composite", "layers": layers})
    if made == 2:
        lengths = rng.dirichlet(np.ones(3)) * reach
        return Link(
            tip=tip,
            section={
                "kind": "stepped",
                "steps": [{"length": x, "section": anything()} for x in lengths],
            },
            material=material(),
        )
    kind = ("tube", "rod", "rectangle", "box", "I")[rng.integers(5)]
    stations = [
        {"at": at * reach, "section": sized(kind)} for at in (0.0, rng.uniform(0.1, 0.9), 1.0)
    ]
    return Link(tip=tip, section={"kind": "tapered", "stations": stations}, material=material())


def test_no_link_of_a_thousand_gives_energy_back():
    """What a load here moves there, a load there moves here; and every load stores energy. Random
    sections, materials, tapers, steps, ends.
    """
    rng = np.random.default_rng(8)
    for _ in range(1000):
        c = ElasticLink(random_link(rng), rng.normal(size=3)).tip_compliance
        scale = np.sqrt(np.diag(c))
        scaled = c / np.outer(scale, scale)
        np.testing.assert_allclose(scaled, scaled.T, rtol=0, atol=1e-12)
        assert np.linalg.eigvalsh(scaled).min() > 0


def test_a_link_answers_in_proportion():
    """Terms under the sum of two loads are the sums of the terms under each: wrench and gravity may
    be taken apart by cause.
    """
    rng = np.random.default_rng(3)
    link = ElasticLink(random_link(rng), AXIS)
    loads, gravities = rng.normal(size=(2, 6)) * 50, rng.normal(size=(2, 3)) * 10
    one, two = (
        terms_at(link, condition(w, gravity=g)) for w, g in zip(loads, gravities, strict=True)
    )
    both = terms_at(link, condition(loads.sum(axis=0), gravity=gravities.sum(axis=0)))
    for a, b, ab in zip(one, two, both, strict=True):
        np.testing.assert_allclose(a.screw + b.screw, ab.screw, rtol=1e-12, atol=1e-20)


MATRIX = Link(
    length=LENGTH,
    section={"kind": "box", "width": 0.05, "height": 0.08, "wall": 0.004},
    material=STEEL,
)


@pytest.mark.parametrize("direction", ["x", "-z", (1.0, 2.0, -0.5)])
def test_the_matrix_of_a_link_is_that_link(direction: str | tuple[float, ...]):
    """The tip compliance of a box, handed over as numbers, bends as the box: under loads on the tip
    and, as it is uniform, under its own weight.
    """
    box = MATRIX.model_copy(update={"direction": direction})
    matrix = ElasticLink(box, AXIS).tip_compliance
    link = ElasticLink(
        Link(
            length=LENGTH,
            direction=direction,
            compliance={"matrix": matrix.tolist()},
            mass=box.total_mass,
        ),
        AXIS,
    )
    np.testing.assert_allclose(link.tip_compliance, matrix, rtol=1e-10, atol=1e-20)
    np.testing.assert_allclose(
        link.own_weight_compliance,
        ElasticLink(box, AXIS).own_weight_compliance,
        rtol=1e-9,
        atol=1e-19,
    )


@pytest.mark.parametrize(("ratio", "off"), [(0.8, 0.035), (0.7, 0.075), (0.5, 0.30)])
def test_the_own_weight_of_a_matrix_is_an_estimate_unless_stated(ratio: float, off: float):
    """By its matrix alone a cone sags as another beam does, off by what the law states; with its
    own weight stated, as it does itself.
    """
    whole = Link(length=LENGTH, material=STEEL, section=cone(0.1 * ratio))
    exact = ElasticLink(whole, AXIS)
    fields = {
        "length": LENGTH,
        "mass": whole.total_mass,
        "centre_of_mass": tuple(whole.mass_centre),
    }
    matrix = exact.tip_compliance.tolist()
    guess = ElasticLink(Link(**fields, compliance={"matrix": matrix}), AXIS).own_weight_compliance[
        5, 2
    ]
    assert 0.8 * off < 1 - guess / exact.own_weight_compliance[5, 2] < off
    told = {"matrix": matrix, "own_weight": exact.own_weight_compliance.tolist()}
    np.testing.assert_array_equal(
        ElasticLink(Link(**fields, compliance=told), AXIS).own_weight_compliance,
        exact.own_weight_compliance,
    )


def test_what_was_measured_is_what_bends():
    """The deflection and slope that a bar shows under a force make a link that bends as that bar:
    also under a moment and its own weight.
    """
    bar = Link(length=LENGTH, section={"kind": "rod", "diameter": 0.04}, material=STEEL)
    c = ElasticLink(bar, AXIS).tip_compliance
    force, torque = 80.0, 20.0
    measured = {
        "force": force,
        "deflection": c[5, 5] * force,
        "slope": -c[1, 5] * force,
        "torque": torque,
        "twist": c[0, 0] * torque,
    }
    link = ElasticLink(Link(length=LENGTH, measured=measured, mass=bar.total_mass), AXIS)
    expected = c.copy()
    expected[3, 3] = 0.0
    np.testing.assert_allclose(link.tip_compliance, expected, rtol=1e-9, atol=1e-20)
    weight = ElasticLink(bar, AXIS).own_weight_compliance
    np.testing.assert_allclose(
        link.own_weight_compliance[:, 2], weight[:, 2], rtol=1e-9, atol=1e-20
    )
    # without a slope all of it is bending: right under the force, the slope 3 delta/(2 l) of a bar
    # that does not shear
    plain = ElasticLink(
        Link(length=LENGTH, measured={"force": force, "deflection": 1e-4}), AXIS
    ).tip_compliance
    assert plain[5, 5] == pytest.approx(1e-4 / force, rel=1e-12)
    assert -plain[1, 5] == pytest.approx(1.5e-4 / LENGTH / force, rel=1e-12)
    assert plain[4, 4] == pytest.approx(plain[5, 5], rel=1e-12)


def test_sideways_is_measured_by_itself():
    """What was measured along the joint's axis bends the link there alone."""
    measured = {"force": 100.0, "deflection": 1e-4, "sideways": {"force": 50.0, "deflection": 3e-4}}
    c = compliance(measured=measured, material=None)
    assert c[5, 5] == pytest.approx(1e-6, rel=1e-12)
    assert c[4, 4] == pytest.approx(6e-6, rel=1e-12)


def test_a_force_beside_the_shear_centre_twists():
    """A section whose shear centre lies e beside its centroid turns by F e l/(G J) under a force
    through the centroid; its energy says so too.
    """
    values = round_section(0.05, 0.04, 0.3)
    shifted = type(values)(
        values.area,
        values.i_y,
        values.i_z,
        values.torsion,
        values.shear_y,
        values.shear_z,
        centre_y=-0.01,
    )
    give = compliance_per_length(E, G, shifted)
    assert give[0, 5] == pytest.approx(0.01 / (G * values.torsion), rel=1e-12)
    # the same force, moved onto the shear centre: no twist
    at_centre = np.array([-0.01 * 1.0, 0, 0, 0, 0, 1.0])
    assert (give @ at_centre)[0] == pytest.approx(0, abs=1e-18)


BOX = {"kind": "box", "width": 0.05, "height": 0.08, "wall": 0.004}
ROD = {"kind": "rod", "diameter": 0.05}
GOOD = np.eye(6) * 1e-6


@pytest.mark.parametrize(
    ("fields", "why"),
    [
        (
            {"section": TUBE_IN_SLEEVE, "material": STEEL},
            "a material beside a section that states its own",
        ),
        (
            {"section": {"kind": "stepped", "steps": [{"length": 0.8, "section": ROD}]}},
            "a section without a material",
        ),
        (
            {
                "section": {
                    "kind": "stepped",
                    "steps": [{"length": 0.8, "section": ROD, "material": STEEL}],
                },
                "material": STEEL,
            },
            "states its own",
        ),
        (
            {
                "section": {"kind": "stepped", "steps": [{"length": 0.7, "section": ROD}]},
                "material": STEEL,
            },
            "700 mm long in a link 800 mm",
        ),
        (
            {
                "section": {
                    "kind": "stepped",
                    "steps": [{"length": 0.8, "section": TUBE_IN_SLEEVE, "material": STEEL}],
                }
            },
            "beside a composite",
        ),
        (
            {
                "section": {
                    "kind": "tapered",
                    "stations": [{"at": 0.1, "section": ROD}, {"at": 0.8, "section": ROD}],
                },
                "material": STEEL,
            },
            "stations at 100",
        ),
        (
            {
                "section": {
                    "kind": "tapered",
                    "stations": [{"at": 0.0, "section": ROD}, {"at": 0.8, "section": BOX}],
                },
                "material": STEEL,
            },
            "rod to a box",
        ),
        (
            {
                "section": {
                    "kind": "I",
                    "width": 0.05,
                    "height": 0.02,
                    "web": 0.005,
                    "flange": 0.01,
                },
                "material": STEEL,
            },
            "flanges 10 mm",
        ),
        (
            {"section": ROD, "material": STEEL, "compliance": {"matrix": GOOD.tolist()}},
            "section beside compliance",
        ),
        ({"length": 0.0, "compliance": {"matrix": GOOD.tolist()}}, "zero length"),
        (
            {"compliance": {"matrix": (GOOD + 5e-7 * np.eye(6, k=1)).tolist()}},
            "across the diagonal",
        ),
        (
            {"compliance": {"matrix": (GOOD - 2e-6 * np.diag([0, 1, 0, 0, 0, 0])).tolist()}},
            "negative entry",
        ),
        (
            {"compliance": {"matrix": (GOOD + 2e-6 * (np.eye(6, k=3) + np.eye(6, k=-3))).tolist()}},
            "not positive definite",
        ),
        ({"compliance": {"matrix": (GOOD * np.nan).tolist()}}, "not finite"),
        (
            {"measured": {"force": 100.0, "deflection": 1e-4, "slope": 1e-3}},
            "bends a bar of 800 mm",
        ),
        ({"measured": {"force": 0.0, "deflection": 1e-4}}, "force or a deflection of zero"),
        ({"measured": {"force": 1.0, "deflection": 1e-4, "torque": 3.0}}, "torque without a twist"),
    ],
)
def test_a_link_that_cannot_be_is_refused(fields: dict[str, object], why: str):
    """Contradictions, lengths that do not fit and matrices that nature does not make are refused
    with the reason.
    """
    with pytest.raises(ValidationError) as caught:
        Link(**{"length": LENGTH, **fields})
    assert why in str(caught.value)


@pytest.mark.parametrize(
    "section",
    [
        {"kind": "tube", "outer": 0.06, "wall": 1e-19},
        {"kind": "box", "width": 0.05, "height": 0.08, "wall": 1e-16},
        {"kind": "I", "width": 0.05, "height": 0.08, "web": 1e-19, "flange": 0.005},
        {"kind": "I", "width": 0.05, "height": 0.08, "web": 0.005, "flange": 1e-19},
    ],
)
def test_a_wall_thinner_than_any_foil_is_refused(section):
    """A wall of a ten-billionth of an atom is a slip of the unit: one mistake, and no stiffness
    that rounding alone would make.
    """
    with pytest.raises(ValidationError, match=r"mm in a section .* mm wide"):
        Link(length=LENGTH, section=section, material=STEEL)
    foil = {
        key: 1e-6 if isinstance(value, float) and value < 1e-9 else value
        for key, value in section.items()
    }
    assert np.isfinite(compliance(section=foil)).all()


def test_a_matrix_of_the_smallest_entries_is_judged_without_a_warning():
    """Two entries whose product is below every float are an extreme that is allowed: no division by
    zero, no warning.
    """
    matrix = np.diag([1e-200, 1e-200, 3e-6, 1e-5, 1e-5, 1e-5])
    assert compliance_error(matrix) is None
