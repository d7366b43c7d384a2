"""Outlines of both wheels of a stage: how exact they are, and stages that are refused before they
are meshed.
"""

from __future__ import annotations

import importlib.util
import math

import numpy as np
import pytest
from scipy.spatial import KDTree

from lostmotion.errors import DidNotConvergeError
from lostmotion.laws.contact import equivalent_modulus
from lostmotion.laws.cycloid.bodies import ElasticBody
from lostmotion.laws.cycloid.contact import Flanks
from lostmotion.laws.cycloid.drive import Drive, loaded_disc, nominal_gaps
from lostmotion.laws.cycloid.finite_elements.contours import contacts
from lostmotion.laws.cycloid.finite_elements.stage import loaded_stage
from lostmotion.laws.cycloid.geometry import flank
from lostmotion.laws.cycloid.stage import Kind, Modification, Stage
from lostmotion.laws.perforated_disc_series import Holes

STAGES = [
    Stage(0.05, 0.003, 0.0012, 20),
    Stage(0.064, 0.003, 0.0013, 40),
    Stage(0.05, 0.003, 0.0012, 20, "planet pins"),
]
DISC, RING = ElasticBody("planet", 0.02, 210e9, 0.3), ElasticBody("ring", 0.06, 210e9, 0.3)


def distances(stage: Stage, points: np.ndarray) -> np.ndarray:
    """Return the distances (m) of points in the frame of the ring, at a crank angle of zero, from
    the flank: from a polygon of 400 000 sides.
    """
    made = contacts(stage, 0.0)
    corners = (0.0 if stage.has_planet_pins else made.planet) + flank(
        stage, np.linspace(0, 2 * math.pi, 400_001)
    )[0] @ np.array([1, 1j])
    _, k = KDTree(np.stack([corners.real, corners.imag], axis=-1)).query(
        np.stack([points.real, points.imag], axis=-1)
    )
    side = corners[(k + 1) % 400_000] - corners[k - 1]
    return np.asarray(np.abs(((points - corners[k]) * np.conj(side / np.abs(side))).imag))


@pytest.mark.slow
@pytest.mark.parametrize("stage", STAGES)
def test_outlines_and_curved_elements_lie_on_the_exact_profile(stage):
    """OpenCASCADE's outline is within 0.02 µm of the flank everywhere; at the contacts it and the
    curved elements are within 0.01 µm.
    """
    import ngsolve as ng

    from lostmotion.laws.cycloid.finite_elements.mesh import MM, Blank, face_of, mesh_of

    made = contacts(stage, 0.0)
    at = {k: np.linspace(-1e-4, 1e-4, 6) for k in range(stage.pins // 2)}
    if stage.has_planet_pins:
        blank = Blank(
            made.ring_outline(at), ElasticBody("ring", stage.ring_radius + 0.01, 210e9, 0.3), 0.0
        )
    else:
        blank = Blank(made.planet_outline(at), DISC, made.planet)
    for name, limit in (("contact", 1e-8), ("free", 2e-8)):
        edges = [edge for edge in face_of(blank).edges if edge.name.startswith(name)]
        starts, ends = np.array([edge.parameter_interval for edge in edges]).T
        places = [
            edge.Value(a + (b - a) * x)
            for edge, a, b in zip(edges, starts, ends, strict=True)
            for x in np.linspace(0, 1, 101)
        ]
        assert (
            distances(stage, np.array([complex(each.x, each.y) for each in places]) / MM).max()
            < limit
        )
    mesh = mesh_of(blank, 3e-3)
    mesh.Curve(2)
    points = mesh.MapToAllElements(ng.IntegrationRule(ng.SEGM, 8), mesh.Boundaries("contact.*"))
    assert (
        distances(
            stage, np.asarray(ng.CoefficientFunction((ng.x, ng.y))(points)) @ np.array([1, 1j]) / MM
        ).max()
        < 1e-8
    )


@pytest.mark.slow
def test_lobes_of_plain_arcs_end_at_the_circle_of_their_centres():
    """Rings with low lobes wind up as their elastic bodies, whose lobes end at the circle of their
    centres too.
    """
    stage = Stage(0.05, 4.88681e-3, 1.48158e-3, 13, "lobe arcs")
    ring = ElasticBody("ring", 0.063, 210e9, 0.3)
    drive = Drive(
        stage,
        Flanks(0.01, equivalent_modulus(210e9, 0.3, 210e9, 0.3)),
        disc_body=DISC,
        ring_body=ring,
    )
    expected = loaded_disc(
        drive, 100.0, np.zeros(1), nominal_gaps(drive, np.zeros(1))
    ).rotation.item()
    assert loaded_stage(stage, DISC, ring, 0.01, np.array([100.0])).rotation[0] == pytest.approx(
        expected, rel=0.003
    )


@pytest.mark.parametrize(
    ("message", "change"),
    [
        (
            "reach in to 45.8 mm: choose a smaller hub",
            {"planet": ElasticBody("planet", 0.046, 210e9, 0.3)},
        ),
        (
            "reach out to 53 mm: choose a larger one",
            {"ring": ElasticBody("ring", 0.0529, 210e9, 0.3)},
        ),
        (
            "leave 0.1 mm to the bore",
            {"planet": ElasticBody("planet", 0.02, 210e9, 0.3, Holes(6, 0.0301, 0.01))},
        ),
        (
            "leave -1.2 mm to the teeth",
            {"planet": ElasticBody("planet", 0.02, 210e9, 0.3, Holes(6, 0.037, 0.01))},
        ),
        (
            "to each other: take smaller holes",
            {"planet": ElasticBody("planet", 0.02, 210e9, 0.3, Holes(20, 0.033, 0.0055))},
        ),
        (
            "interfere before they are loaded, at pin 0 by 2 µm",
            {"relief": Modification(roller=-2e-6)},
        ),
        (
            "interfere before they are loaded, at pin 3 by 1 µm",
            {"gaps": np.where(np.arange(20) == 3, -1e-6, 0.0)},
        ),
        ("torques must be above zero", {"torques": np.zeros(1)}),
    ],
)
def test_stages_that_cannot_be_meshed_are_refused_before_ngsolve_is_needed(
    monkeypatch, message, change
):
    """Thin rims and webs, interfering flanks and loads that are none are refused with their sizes,
    without NGSolve.
    """
    monkeypatch.setattr(importlib.util, "find_spec", lambda _: None)
    case = {"planet": DISC, "ring": RING, "torques": np.array([100.0]), **change}
    with pytest.raises(ValueError, match=message):
        loaded_stage(
            STAGES[0], case.pop("planet"), case.pop("ring"), 0.01, case.pop("torques"), **case
        )


@pytest.mark.parametrize(
    ("message", "kind", "eccentricity", "pin"),
    [
        ("second branch of the envelope folds", "lobe envelope", 0.0023, 0.003),
        ("undercuts the flank", "ring pins", 0.0012, 0.02),
        ("loops", "lobe arcs", 0.003, 0.003),
    ],
)
def test_folded_and_undercut_profiles_are_no_stages(message, kind: Kind, eccentricity, pin):
    """Folded envelopes, undercut flanks and profiles with loops are refused as stages, so none
    reaches a mesh.
    """
    with pytest.raises(ValueError, match=message):
        Stage(0.05, pin, eccentricity, 20, kind)


def test_contacts_wider_than_their_lobes_are_refused_before_meshing(monkeypatch):
    """A rubber disc under the torque of a steel one would be squeezed past its lobes."""
    import lostmotion.laws.cycloid.finite_elements.stage as module

    monkeypatch.setattr(module, "check_installed", lambda: None)
    with pytest.raises(
        DidNotConvergeError,
        match="outgrow their lobes: take a smaller torque or a stiffer material",
    ):
        loaded_stage(
            STAGES[0], ElasticBody("planet", 0.02, 5e6, 0.45), None, 0.01, np.array([400.0])
        )
