"""The bodies of a cycloidal stage: limits with closed forms, the local parts of the contact, and
properties of every stage.
"""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
import pytest
from hypothesis import assume, given, settings
from hypothesis import strategies as st

from lostmotion.laws.annulus import ELLIPTIC, Annulus, Plane, spectrum
from lostmotion.laws.annulus import flexibility as edge_flexibility
from lostmotion.laws.cycloid.bodies import ElasticBody, _rim, flexibility
from lostmotion.laws.cycloid.contact import Flanks, load_sharing
from lostmotion.laws.cycloid.geometry import arms, contact_radius, normals, pin_angles
from lostmotion.laws.cycloid.stage import Part, Stage
from tests.laws.closed_forms import approach

# A row of docs/validation.md each: quantity, compared with, agreement, other files.
VALIDATES = (
    (
        "disc and ring of a stage as elastic bodies",
        "torsion and a force in an infinite plane in closed form; arcs in place of the flank",
        "1e-3; 1e-4; 2 %",
        "laws/cycloid/bodies.py",
    ),
)

YOUNG, NU, WIDTH = 210e9, 0.3, 0.012
SHEAR = YOUNG / (2 + 2 * NU)
PLANE = YOUNG / (1 - NU**2)
STAGES = [
    Stage(0.05, 0.003, 0.0012, 20, "lobe arcs"),
    Stage(0.0775, 0.004, 0.0015, 40),
    Stage(0.0775, 0.004, 0.0015, 40, "lobe envelope"),
    Stage(0.0775, 0.002, 0.0012, 30, "planet pins"),
]


def compliance(
    stage: Stage,
    part: Part,
    edge: float,
    crank: float = 0.0,
    width: float = WIDTH,
    young: float = YOUNG,
    plane: Plane = "strain",
):
    """Return the displacements (N, N) of a body along the contacts under unit forces, m/N."""
    return flexibility(
        stage, ElasticBody(part, edge, young, NU, plane=plane), width, np.array([crank])
    )[0, 0]


def turned(
    stage: Stage,
    part: Part,
    edge: float,
    crank: float = 0.0,
    forces: np.ndarray | None = None,
    **others,
) -> float:
    """Return the rotation of the output per torque, rad/(N m), from a body under forces on the
    lobes; by default those of equal springs.
    """
    arm = arms(stage, pin_angles(stage, np.array([crank]))[0])
    force = np.maximum(arm, 0.0) if forces is None else forces
    return (
        float(force @ compliance(stage, part, edge, crank, **others) @ force)
        / float(force @ arm) ** 2
    )


PARTS: tuple[tuple[Part, float], ...] = (("planet", 0.02), ("ring", 0.12))


@st.composite
def stages(draw: st.DrawFn) -> Stage:
    """Return possible stages of every kind."""
    pins, shortening, share = (
        draw(st.integers(8, 40)),
        draw(st.floats(0.2, 0.9)),
        draw(st.floats(0.3, 0.8)),
    )
    kind = draw(st.sampled_from(["ring pins", "lobe arcs", "lobe envelope", "planet pins"]))
    try:
        return Stage(
            0.1, share * 0.1 * math.sin(math.pi / pins), shortening * 0.1 / pins, pins, kind
        )
    except ValueError:
        assume(False)
        raise


@pytest.mark.parametrize("stage", STAGES)
def test_a_thin_hub_leaves_torsion_alone(stage: Stage):
    """For a very small hub the compliance is that of torsion, T/(4 pi G b a^2), so the moment of
    the forces is exact, for every kind.
    """
    hub = 1e-4
    torsion = (hub**-2 - _rim(stage, "planet") ** -2) / (4 * math.pi * SHEAR * WIDTH)
    assert turned(stage, "planet", hub, 0.1) == pytest.approx(torsion, rel=1e-3)


@pytest.mark.parametrize("stage", STAGES)
def test_a_thick_ring_moves_as_a_whole(stage: Stage):
    """Ten times the outer radius adds k P^2 ln(10)/(2 pi G b (1 + k)) of the forces' resultant P: a
    force in an infinite plane.
    """
    forces = np.maximum(arms(stage, pin_angles(stage, np.array([0.1]))[0]), 0)
    force = np.linalg.norm(forces @ normals(stage, pin_angles(stage, np.array([0.1]))[0]))
    torque = forces @ arms(stage, pin_angles(stage, np.array([0.1]))[0])
    k = 3 - 4 * NU
    expected = k * (force / torque) ** 2 * math.log(10) / (2 * math.pi * SHEAR * WIDTH * (1 + k))
    far, near = (turned(stage, "ring", outer, 0.1) for outer in (1000.0, 100.0))
    # the resultant of a distributed load is smaller by the first harmonic of its arc
    pinned = stage.kind in {"ring pins", "lobe arcs"}
    waves = stage.pins if stage.kind == "lobe envelope" else stage.lobes
    lacks = (
        1 - float(spectrum(np.array(math.pi / (2 * waves)), ELLIPTIC))
        if not pinned
        else (stage.pin_radius / stage.ring_radius) ** 2
    )
    assert lacks < 0.004
    assert far - near == pytest.approx(expected, rel=max(2 * lacks, 1e-4))


@pytest.mark.parametrize("slant", [0.0, 0.3, 0.6])
@pytest.mark.parametrize("nu_plane", [0.3, 3 / 7])
def test_a_slanted_half_ellipse_on_a_half_plane(slant: float, nu_plane: float):
    """From the middle of the load down its direction to D: p/(pi E') [2 ln(2 D/w) + 1 - (1 + nu')
    cos^2 s], the mean 1/2 less.

    Flamant's strains of point loads along the surface, integrated over the load and down the line
    of the force.
    """
    depth, count = 300.0, 400
    steps = np.arange(1, count + 1) * math.pi / (count + 1)
    share = 2 / (count + 1) * np.sin(steps) ** 2
    offset = np.cos(steps)  # w = 1
    # the surface is y = 0, the body is at y > 0
    force = np.array([math.sin(slant), math.cos(slant)])
    logs, weights = np.polynomial.legendre.leggauss(600)
    down = np.exp((logs + 1) / 2 * math.log(depth / 1e-2) + math.log(1e-2))
    from_load = down[:, None, None] * force - np.stack([offset, 0 * offset], axis=-1)
    distance = np.linalg.norm(from_load, axis=-1)
    cosine = from_load @ force / distance
    # the only stress is radial, -2 cos/(pi r); its strain along the force
    strain = 2 * cosine / distance * (cosine**2 - nu_plane * (1 - cosine**2))
    moved = float((strain @ share * down) @ weights) * math.log(depth / 1e-2) / 2
    # the omitted first hundredth of w contributes about as much as the tolerance
    assert moved == pytest.approx(
        2 * math.log(2 * depth) + 1 - (1 + nu_plane) * math.cos(slant) ** 2, abs=0.03
    )


@pytest.mark.parametrize("share", [0.3, 0.6, 1.0])
def test_a_round_disc_with_loaded_arcs_is_nearly_as_soft(share: float):
    """An annulus of the flank's mean radius, loaded over arcs with their local correction, turns as
    far as the disc with its flank, to 2 %.
    """
    stage, hub = STAGES[0], 0.02
    theta = pin_angles(stage, np.array([0.1]))[0]
    arm, radius = arms(stage, theta), _rim(stage, "planet")
    along = np.arctan2(*normals(stage, theta).T[::-1])
    slant = np.arcsin(arm / radius)
    reach = share * radius * math.pi / (2 * stage.lobes)
    body = Annulus(radius, hub, WIDTH, YOUNG, NU)
    matched = 4 * contact_radius(stage, theta) * np.exp(-0.75 + np.sin(slant) ** 2 / (2 * (1 - NU)))
    anew = edge_flexibility(body, along - slant, slant, reach / radius) + np.diag(
        2 * np.log(reach / matched) / (math.pi * PLANE * WIDTH)
    )
    forces = np.maximum(arm, 0)
    assert forces @ anew @ forces / (forces @ arm) ** 2 == pytest.approx(
        turned(stage, "planet", hub, 0.1), rel=0.02
    )


@pytest.mark.parametrize("stage", STAGES)
def test_contact_and_bodies_together_store_energy(stage: Stage):
    """The matrix of the body alone can have a negative diagonal, where Johnson's law includes too
    much; with the loaded contacts it is positive.
    """
    answer = load_sharing(stage, Flanks(WIDTH, PLANE / 2), [200.0], [0.05]).checked()
    forces = answer.forces[0, 0, 0]
    on = forces > 0
    step = 1e-6 * forces.max()
    law = lambda f: approach(  # noqa: E731
        "johnson",
        f,
        WIDTH,
        contact_radius(stage, pin_angles(stage, np.array([0.05]))[0]),
        PLANE / 2,
    )
    slope = (law(forces + step) - law(np.maximum(forces - step, 0))) / (
        forces + step - np.maximum(forces - step, 0)
    )
    bodies = sum(compliance(stage, part, edge, 0.05) for part, edge in PARTS)
    assert np.linalg.eigvalsh((bodies + np.diag(slope))[np.ix_(on, on)]).min() > 0


@pytest.mark.parametrize("stage", STAGES)
def test_the_compliance_repeats_with_the_pins(stage: Stage):
    """The crank rotated by one pin's share shifts the forces by one pin; the opposite torque
    mirrors the drive.
    """
    pitch = 2 * math.pi / stage.pins / (stage.lobes / stage.pins if stage.has_planet_pins else 1)
    for part, edge in PARTS:
        here = compliance(stage, part, edge, 0.03)
        np.testing.assert_allclose(
            compliance(stage, part, edge, 0.03 + pitch),
            np.roll(here, (1, 1), axis=(0, 1)),
            rtol=1e-9,
        )
        # pin k is at the angle of pin -k
        mirror = -np.arange(stage.pins) % stage.pins
        np.testing.assert_allclose(
            compliance(stage, part, edge, -0.03)[np.ix_(mirror, mirror)],
            here,
            rtol=1e-6,
            atol=1e-9 * here.max(),
        )


@settings(max_examples=15, deadline=None)
@given(
    stages(), st.floats(0.05, 0.35), st.floats(1.05, 1.5), st.floats(1.02, 2.0), st.floats(0, 6.3)
)
def test_less_material_between_the_edges_is_stiffer(
    stage: Stage, hub: float, larger: float, outer: float, crank: float
):
    """A larger hub, and a ring fixed nearer to its teeth, are stiffer; modulus and width act in
    proportion.
    """
    smaller = hub * 0.1
    assert turned(stage, "planet", smaller * larger, crank) < turned(
        stage, "planet", smaller, crank
    )
    near = 0.15 * outer
    assert turned(stage, "ring", near, crank) < turned(stage, "ring", near * larger, crank)
    for part, edge in (("planet", smaller), ("ring", near)):
        before = compliance(stage, part, edge, crank)
        np.testing.assert_allclose(
            compliance(stage, part, edge, crank, young=YOUNG / 2), 2 * before, rtol=1e-9
        )
        np.testing.assert_allclose(
            compliance(stage, part, edge, crank, width=WIDTH / 3), 3 * before, rtol=1e-9
        )
        np.testing.assert_array_equal(before, before.T)


def test_plane_stress_is_softer():
    """A thin disc can expand laterally: it deflects more than a wide one, by less than 1/(1 - nu^2)
    where shear dominates.
    """
    for part, edge in (("planet", 0.02), ("ring", 0.06)):
        wide, thin = (turned(STAGES[0], part, edge, plane=plane) for plane in ("strain", "stress"))
        assert 1 < thin / wide < 1.15


def test_impossible_bodies_are_refused():
    """A hub that is too large and a ring that is too small are refused."""
    stage = STAGES[0]
    with pytest.raises(
        ValueError, match=r"hub's radius is 46 mm, but teeth or seats reach in to 45\.8 mm"
    ):
        compliance(stage, "planet", 0.046)
    with pytest.raises(
        ValueError, match=r"outer radius is 50 mm, but teeth or seats reach out to 50 mm"
    ):
        compliance(stage, "ring", 0.05)
    with pytest.raises(ValueError, match="reach out to 53 mm"):
        compliance(replace(stage, kind="ring pins"), "ring", 0.052)
