"""Discs with holes by finite elements (NGSolve): bearings of crankshafts on a round disc, output
pins in a stage with its contacts.
"""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, Any

import numpy as np
import pytest

from lostmotion.laws.contact import equivalent_modulus
from lostmotion.laws.cycloid.bodies import ElasticBody, flexibility
from lostmotion.laws.cycloid.contact import Flanks, load_sharing
from lostmotion.laws.cycloid.finite_elements.stage import loaded_stage
from lostmotion.laws.cycloid.stage import Stage
from lostmotion.laws.perforated_disc_series import Holes
from tests.laws.test_perforated_disc import CRANKS, with_cranks

if TYPE_CHECKING:
    from collections.abc import Callable

    from lostmotion.laws.annulus import Annulus
    from lostmotion.laws.perforated_disc import RimLoads

# A row of docs/validation.md each: quantity, compared with, agreement, other files.
VALIDATES = (
    (
        "holes near the flank of a disc",
        (
            "finite elements of the whole contact, mean over four positions of the holes: N 14 "
            "with webs of 3 mm, N 16"
        ),
        "2 %; 0.5 %",
        "laws/perforated_disc.py",
    ),
)


class FreeDisc:
    """A meshed disc that nothing holds: the rotation of balanced loads follows from the energy."""

    def __init__(self, body: Annulus, holes: Holes, size: float) -> None:
        """Mesh and factorise; `size` of the elements at the rim."""
        self.ng, self.body, self.holes = pytest.importorskip("ngsolve"), body, holes
        ng, occ = self.ng, pytest.importorskip("netgen.occ")

        def circle(centre: complex, radius: float, name: str, size: float) -> Any:
            out = occ.Circle(occ.Pnt(centre.real, centre.imag), radius).Face()
            out.edges.name, out.edges.maxh = name, size
            return out

        face = circle(0j, body.loaded, "rim", size) - circle(0j, body.fixed, "bore", body.fixed / 4)
        for k, place in enumerate(holes.circle * holes.places):
            face = face - circle(complex(place), holes.radius, f"hole{k}", holes.radius / 5)
        mesh = ng.Mesh(occ.OCCGeometry(face, dim=2).GenerateMesh(maxh=body.loaded / 10)).Curve(4)
        self.space = ng.VectorH1(mesh, order=4)
        u, v = self.space.TnT()
        shear = body.young / (2 + 2 * body.nu)
        volume = (
            2
            * shear
            * (body.nu / (1 - 2 * body.nu) if body.plane == "strain" else body.nu / (1 - body.nu))
        )
        form = ng.BilinearForm(self.space)
        form += (
            volume * ng.div(u) * ng.div(v)
            + 2 * shear * ng.InnerProduct(ng.Sym(ng.Grad(u)), ng.Sym(ng.Grad(v)))
        ) * ng.dx
        form += 1e-6 * shear / body.loaded**2 * u * v * ng.dx  # balanced loads do not feel it
        self.form = form.Assemble()
        self.inverse = form.mat.Inverse(self.space.FreeDofs(), inverse="sparsecholesky")
        self.rigid = np.array(
            [self.unknowns(mode) for mode in ((1.0, 0.0), (0.0, 1.0), (-ng.y, ng.x))]
        )
        self.weighted = np.array(
            [self.assembled(ng.dx, ng.CF(mode)) for mode in ((1.0, 0.0), (0.0, 1.0), (-ng.y, ng.x))]
        )

    def unknowns(self, field: tuple[Any, Any]) -> np.ndarray:
        """Return the unknowns of a displacement."""
        moved = self.ng.GridFunction(self.space)
        moved.Set(self.ng.CF(field))
        return np.asarray(moved.vec.FV().NumPy().copy())

    def assembled(self, where: Any, traction: Any) -> np.ndarray:
        """Return the load of a traction or of a volume force."""
        load = self.ng.LinearForm(traction * self.space.TestFunction() * where)
        return np.asarray(load.Assemble().vec.FV().NumPy().copy())

    def load(self, centre: complex, edge: str, traction: Callable[[Any, Any], Any]) -> np.ndarray:
        """Return the load of a traction on a circular edge, a function of the unit vector (x, y)
        from its centre.
        """
        x, y = self.ng.x - centre.real, self.ng.y - centre.imag
        length = self.ng.sqrt(x * x + y * y)
        return self.assembled(self.ng.ds(edge, bonus_intorder=16), traction(x / length, y / length))

    def on_rim(self, rim: RimLoads, line: float, force: np.ndarray) -> np.ndarray:
        """Return the load of half-elliptic forces on the rim."""

        def traction(x: Any, y: Any) -> Any:
            out = 0.0 * self.ng.CF((x, y))
            for f, at, slant in zip(force, rim.angle + line, rim.slant, strict=True):
                c, s = math.cos(at), math.sin(at)
                off = self.ng.atan2(y * c - x * s, x * c + y * s) / rim.half
                size = (
                    f
                    * 2
                    / (math.pi * rim.half * self.body.loaded)
                    * self.ng.sqrt(self.ng.IfPos(1 - off * off, 1 - off * off, 0.0))
                )
                out += -size * self.ng.CF(
                    (
                        x * math.cos(slant) - y * math.sin(slant),
                        x * math.sin(slant) + y * math.cos(slant),
                    )
                )
            return out

        return self.load(0j, "rim", traction)

    def in_hole(self, number: int, force: complex) -> np.ndarray:
        """Return the load of a cosine pressure on half of a hole."""

        def traction(x: Any, y: Any) -> Any:
            along = x * force.real + y * force.imag
            return (
                2
                / (math.pi * self.holes.radius)
                * self.ng.IfPos(along, along, 0.0)
                * self.ng.CF((x, y))
            )

        return self.load(
            complex(self.holes.circle * self.holes.places[number]), f"hole{number}", traction
        )

    def work(self, load: np.ndarray) -> float:
        """Return the work of a load in its own displacement, without the resultant that is the
        error of the quadrature.
        """
        load = load - self.weighted.T @ np.linalg.solve(
            self.rigid @ self.weighted.T, self.rigid @ load
        )
        vector, answer = self.form.mat.CreateColVector(), self.form.mat.CreateColVector()
        vector.FV().NumPy()[:] = load
        answer.data = self.inverse * vector
        return float(load @ answer.FV().NumPy())


@pytest.mark.slow
@pytest.mark.parametrize("case", CRANKS)
def test_discs_on_crankshafts_agree_with_curved_finite_elements(case):
    """The figures of another finite element code, and so those of the series, within 0.1 %; the
    bearings share force and torque by statics.
    """
    body, holes, rim, line = with_cranks(case)
    disc = FreeDisc(body, holes, rim.half * body.loaded / 2)
    for sign, expected in ((-1, case[-2]), (1, case[-1])):
        force = np.maximum(sign * rim.arm, 0.0)
        load = disc.on_rim(rim, line, force)
        x, y, moment = disc.rigid @ load
        for k, place in enumerate(holes.places):
            load += disc.in_hole(
                k,
                complex(
                    -complex(x, y) / holes.count
                    - 1j * place * moment / (holes.count * holes.circle)
                ),
            )
        assert disc.work(load) / moment**2 == pytest.approx(expected, rel=1e-3)


@pytest.mark.slow
@pytest.mark.parametrize(
    ("stage", "bore", "holes", "torque", "pitches", "within"),
    [
        (
            Stage(0.034, 0.0035, 0.0015, 14),
            0.0105,
            Holes(8, 0.02, 0.00605),
            20.0,
            (0, 28, 22, 50),
            0.02,
        ),
        (
            Stage(0.034, 0.003, 0.0012, 16),
            0.01,
            Holes(6, 0.0195, 0.006),
            20.0,
            (0, 58, 56, 22),
            0.005,
        ),
    ],
)
def test_holes_near_the_flank_agree_with_finite_elements_of_the_whole_contact(
    stage, bore, holes, torque, pitches, within
):
    """Rotation of a steel disc in a rigid ring, mean over four positions of the holes: 2 % with
    webs of 3 mm below valleys of 1.5 mm, else 0.5 %.
    """
    pytest.importorskip("ngsolve")
    body, load = ElasticBody("planet", bore, 210e9, 0.3, holes), np.array([torque])
    # turned by whole pitches of the pins, so that only the holes move
    cranks = 2 * math.pi / stage.pins * np.array(pitches)
    found = [
        float(loaded_stage(stage, body, None, 0.01, load, crank=crank).rotation[0])
        for crank in cranks.tolist()
    ]
    flanks = Flanks(0.01, equivalent_modulus(210e9, 0.3, 1e22, 0.3))
    own = load_sharing(
        stage, flanks, load, [0.0], bodies=flexibility(stage, body, 0.01, np.zeros(1))
    ).checked()
    assert float(own.rotation[0, 0, 0]) == pytest.approx(float(np.mean(found)), rel=within)
