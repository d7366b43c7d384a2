"""Finite elements of a stage in three dimensions against both plane states, and against elements
without polynomials over the width.
"""

from __future__ import annotations

import functools
from dataclasses import replace
from typing import TYPE_CHECKING

import numpy as np
import pytest

from lostmotion.errors import DidNotConvergeError
from lostmotion.laws.cycloid.bodies import ElasticBody
from lostmotion.laws.cycloid.finite_elements.contours import contacts, toothed
from lostmotion.laws.cycloid.finite_elements.elasticity import Elasticity
from lostmotion.laws.cycloid.finite_elements.mesh import MM, Blank, Meshes, face_of, mesh_of
from lostmotion.laws.cycloid.finite_elements.stage import loaded_stage
from lostmotion.laws.cycloid.finite_elements.wheel import ElasticWheel
from lostmotion.laws.cycloid.stage import Stage
from lostmotion.laws.perforated_disc_series import Holes

if TYPE_CHECKING:
    from lostmotion.laws.annulus import Plane

# A row of docs/validation.md each: quantity, compared with, agreement, other files.
VALIDATES = (
    (
        "finite elements of a cycloidal stage in three dimensions",
        (
            "cubic tetrahedra of a disc under one patch of pressure; plane strain and plane "
            "stress as bounds of the stage, and as its limits "
            "when wide and thin; a second term over the width; no lateral contraction"
        ),
        "0.9 % with one term, 0.2 % with two; 1 %, 3 % of the difference; 0.6 %; 2e-5",
        "laws/cycloid/finite_elements/elasticity.py laws/cycloid/finite_elements/wheel.py",
    ),
)

STAGE = Stage(0.05, 0.003, 0.0012, 20)
# With half as many pins, and so in half the time.
SMALL = Stage(0.05, 0.003, 0.0024, 10)
PLANET = ElasticBody("planet", 0.02, 210e9, 0.3)
# The same wheels under several elastic laws and widths have the same meshes.
MESHES = Meshes()


@functools.cache
def rotation(
    width: float, terms: int, plane: Plane = "strain", holes: Holes | None = None, order: int = 2
) -> float:
    """Return the rotation (rad) of the small stage with a rigid ring under 100 N m on 10 mm of
    width, or the same per width.

    Elements of first order change it by 0.6 %, and hardly what states differ by.
    """
    planet = replace(PLANET, plane=plane, holes=holes)
    torques = np.array([1e4 * width])
    solved = loaded_stage(
        SMALL, planet, None, width, torques, terms=terms, order=order, meshes=MESHES
    )
    return float(solved.rotation[0])


@pytest.mark.slow
def test_a_disc_of_some_width_lies_between_plane_strain_and_plane_stress():
    """By both energy theorems the rotation lies between the plane states: near stress if thin, near
    strain if wide, half way at 10 mm.
    """
    strain, stress = (rotation(0.01, 0, plane) for plane in ("strain", "stress"))
    thin, medium, wide = (
        (rotation(width, 1) - strain) / (stress - strain) for width in (1e-4, 0.01, 1.0)
    )
    assert 1.0 < stress / strain < 1 / 0.91
    assert 0.97 < thin < 1.0
    assert medium == pytest.approx(0.474, abs=0.005)
    assert 0.0 < wide < 0.01


@pytest.mark.slow
def test_a_second_term_over_the_width_makes_the_stage_half_a_per_cent_softer():
    """More terms make any body softer; the second one by 0.5 % of the rotation of the stage, which
    is the error of the first alone.
    """
    one, two = (rotation(0.01, terms, order=1) for terms in (1, 2))
    assert 1.003 < two / one < 1.006


@pytest.mark.slow
def test_with_output_pins_in_holes_a_disc_lies_between_the_plane_states_too():
    """A bore that slides on its bearing and pins in six holes do not change the order of the three
    states.
    """
    holes = Holes(6, 0.033, 0.006)
    strain, between, stress = (
        rotation(0.01, 0, holes=holes, order=1),
        rotation(0.01, 1, holes=holes, order=1),
        rotation(0.01, 0, "stress", holes, order=1),
    )
    assert strain < between < stress
    assert 0.2 < (between - strain) / (stress - strain) < 0.8


@pytest.mark.slow
def test_one_pressure_on_a_disc_moves_it_as_by_tetrahedra():
    """Under a patch of pressure one term over the width moves a disc as far as cubic tetrahedra of
    the whole solid to 0.9 %, two terms to 0.2 %.
    """
    import ngsolve as ng
    from netgen.occ import OCCGeometry, Z

    width, lobe = 0.008, 5
    made = contacts(STAGE, 0.0)
    at = {lobe: np.linspace(-5e-4, 5e-4, 6)}
    blank = Blank(toothed(made, at), PLANET, made.planet)
    found = [
        ElasticWheel(
            blank, Elasticity(PLANET, width, n), made, at, mesh_of(blank, 3e-3), 3
        ).compliance.sum()
        for n in (1, 2)
    ]

    half = face_of(blank).Extrude(MM * width / 2 * Z)
    touched = MM * (made.pin[lobe] + STAGE.pin_radius * made.towards[lobe])
    for each in half.faces:
        centre = each.center
        at_contact = abs(complex(centre.x, centre.y) - touched) < 0.6
        at_hub = all(
            abs(abs(complex(edge.start.x, edge.start.y) - MM * made.planet) - 20) < 1e-6
            for edge in each.edges
        )
        flat = all(abs(edge.start.z) + abs(edge.end.z) < 1e-9 for edge in each.edges)
        each.name = (
            "middle"
            if flat
            else "contact"
            if at_contact and centre.z < width * MM / 2 - 1e-6
            else "hub"
            if at_hub
            else "free"
        )
        if each.name == "contact":
            each.maxh = 0.5
    mesh = ng.Mesh(OCCGeometry(half).GenerateMesh(maxh=4, grading=0.5))
    mesh.Curve(3)
    space = ng.VectorH1(mesh, order=3, dirichlet="hub", dirichletz="middle")
    u, v = space.TnT()
    law = Elasticity(PLANET, width, 1)
    form = ng.BilinearForm(space, symmetric=True)
    lame = 2 * law.shear_modulus * 0.3 / (1 - 2 * 0.3)
    form += (
        lame * ng.div(u) * ng.div(v)
        + 2 * law.shear_modulus * ng.InnerProduct(ng.Sym(ng.Grad(u)), ng.Sym(ng.Grad(v)))
    ) * ng.dx
    away = ng.CoefficientFunction(
        (ng.x - MM * made.pin[lobe].real, ng.y - MM * made.pin[lobe].imag, 0)
    )
    load = ng.LinearForm(away / ng.Norm(away) * v * ng.ds("contact"))
    form.Assemble()
    load.Assemble()
    moved = load.vec.CreateVector()
    moved.data = form.mat.Inverse(space.FreeDofs(), inverse="sparsecholesky") * load.vec
    # the wheel's pressure acts on 1 mm of the pin, this one on the flank, which is longer
    length = ng.Integrate(ng.CoefficientFunction(1) * ng.ds("contact"), mesh) / (MM * width / 2)
    assert length == pytest.approx(1.0146, abs=1e-4)
    solid = ng.InnerProduct(moved, load.vec) / (MM * width / 2) / length**2
    assert found[0] == pytest.approx(solid, rel=0.009)
    assert found[1] == pytest.approx(solid, rel=0.002)


@pytest.mark.slow
def test_stages_of_too_many_unknowns_are_refused_before_they_are_solved():
    """Five terms of order five on a fine mesh would not fit into memory."""
    with pytest.raises(DidNotConvergeError, match="million unknowns, more than 2 million"):
        loaded_stage(STAGE, PLANET, None, 0.01, np.array([100.0]), terms=5, order=5)


@pytest.mark.slow
def test_poisson_ratio_zero_leaves_no_difference():
    """Without lateral contraction three dimensions, plane strain and plane stress are the same."""
    disc, torques, meshes = replace(PLANET, nu=0.0), np.array([100.0]), Meshes()
    plane, solid = (
        float(loaded_stage(SMALL, disc, None, 0.01, torques, terms=n, meshes=meshes).rotation[0])
        for n in (0, 1)
    )
    # NGSolve integrates curved elements of the two spaces by different rules
    assert solid == pytest.approx(plane, rel=2e-5)
