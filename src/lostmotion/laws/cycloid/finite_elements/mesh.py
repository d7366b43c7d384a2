"""The mesh of a wheel by NGSolve, from its outline with corners at the ends of the contacts'
intervals.

Lengths are in mm inside meshes, because OpenCASCADE's tolerances are meant for lengths of about
one.
"""

from __future__ import annotations

import importlib.util
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, Final

import numpy as np

from lostmotion.errors import DidNotConvergeError, LostmotionError

if TYPE_CHECKING:
    from lostmotion.laws.cycloid.bodies import ElasticBody
    from lostmotion.laws.cycloid.finite_elements.contours import Edge

MM: Final = 1e3
# Growth of the size of elements away from small ones.
_GRADING: Final = 0.3
# Largest distance, m, of two places that are one.
_SAME_PLACE: Final = 1e-9


def check_installed() -> None:
    """Raise LostmotionError where NGSolve is not installed."""
    if importlib.util.find_spec("ngsolve") is None:
        raise LostmotionError(
            "finite elements need NGSolve, which is not installed\n  pip install 'lostmotion[fem]'"
        )


@dataclass(frozen=True, slots=True)
class LoadedHole:
    """A hole of the planet: centre and radius, m, and the force of its pin under a unit torque."""

    centre: complex
    radius: float
    force: complex


@dataclass(frozen=True, slots=True)
class Blank:
    """A wheel before meshing: closed outline with its teeth or pins, body, centre of its fixed
    circle (m), and holes that take the torque.
    """

    outline: list[Edge]
    body: ElasticBody
    centre: complex
    holes: tuple[LoadedHole, ...] = ()


def mesh_of(blank: Blank, coarse: float) -> Any:  # noqa: ANN401 - NGSolve publishes no types
    """Return the mesh of a wheel with elements up to the size `coarse` (m), and one element for
    each interval of a contact.
    """
    import ngsolve as ng
    from netgen.occ import OCCGeometry

    ng.ngsglobals.msg_level = 0
    return ng.Mesh(
        OCCGeometry(face_of(blank), dim=2).GenerateMesh(maxh=MM * coarse, grading=_GRADING)
    )


def face_of(blank: Blank) -> Any:  # noqa: ANN401
    """Return a wheel as a plane face of OpenCASCADE, mm, with named edges: "fixed", "hole k",
    "contact k", and "free" for the others.
    """
    from netgen.occ import ArcOfCircle, Circle, Dir, Face, Pnt, Segment, SplineInterpolation, Wire
    from scipy.spatial import KDTree

    def place(z: complex) -> Any:  # noqa: ANN401
        return Pnt(MM * z.real, MM * z.imag, 0)

    pieces = []
    for edge in blank.outline:
        points = [place(each) for each in edge.points]
        if edge.straight:
            pieces.append(Segment(points[0], points[-1]))
        else:
            pieces.append(
                ArcOfCircle(*points) if edge.arc else SplineInterpolation(points, tol=1e-9)
            )

    def disc(centre: complex, radius: float) -> Any:  # noqa: ANN401
        return Face(Wire([Circle(place(centre), Dir(0, 0, 1), MM * radius)]))

    fixed, toothed = disc(blank.centre, blank.body.edge), Face(Wire(pieces))
    face = fixed - toothed if blank.body.part == "ring" else toothed - fixed
    for hole in blank.holes:
        face = face - disc(hole.centre, hole.radius)
    circles = {"fixed": (blank.centre, blank.body.edge)} | {
        f"hole {k}": (hole.centre, hole.radius) for k, hole in enumerate(blank.holes)
    }
    own = [edge for edge in blank.outline if edge.contact >= 0]
    middles = KDTree(
        np.array([[z.real, z.imag] for z in (edge.points.mean() for edge in own)]) * MM
    )
    hit = 0
    for edge in face.edges:  # names that are set before a boolean are lost
        ends = np.array([complex(end.x, end.y) for end in (edge.start, edge.end)]) / MM
        off, near = middles.query([ends.mean().real * MM, ends.mean().imag * MM])
        edge.name = next(
            (
                name
                for name, (centre, radius) in circles.items()
                if np.abs(np.abs(ends - centre) - radius).max() < _SAME_PLACE
            ),
            "free",
        )
        if edge.name == "free" and off < 0.1 * MM * abs(own[near].points[-1] - own[near].points[0]):
            edge.name = f"contact {own[near].contact}"
            hit += 1
    if hit != len(own) or {edge.name for edge in face.edges} < circles.keys():
        raise DidNotConvergeError(
            f"the outline has {hit} of {len(own)} pieces of contacts, or misses a circle"
        )
    return face
