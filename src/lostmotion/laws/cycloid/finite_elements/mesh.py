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
    from lostmotion.laws.cycloid.finite_elements.selection import OnEnvelope, OnPins

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


class Meshes:
    """Coarser and finer meshes of wheels, kept for the same wheels under another elastic law.

    flanks  which parts are meshed as contacts, as far as they have grown: under another law they
            are as large or nearly so, and every attempt with contacts too small is a whole solution
    """

    def __init__(self) -> None:
        """Begin without meshes."""
        self.flanks: dict[tuple[object, ...], OnPins | OnEnvelope] = {}
        self._kept: dict[tuple[object, ...], tuple[Any, Any]] = {}

    def of(self, blank: Blank, coarse: float) -> tuple[Any, Any]:
        """Return the mesh of a wheel as `mesh_of`, and one whose elements are half as large."""
        import ngsolve as ng

        key = (
            *((edge.contact, edge.points.tobytes()) for edge in blank.outline),
            *((hole.centre, hole.radius) for hole in blank.holes),
            (blank.body.part, blank.body.edge, blank.centre, coarse),
        )
        if key not in self._kept:
            mesh = mesh_of(blank, coarse)
            # a copy of straight elements, for curved ones would be placed on the outline twice
            fine = ng.Mesh(mesh.ngmesh.Copy())
            fine.Refine()
            self._kept[key] = mesh, fine
        return self._kept[key]


def face_of(blank: Blank) -> Any:  # noqa: ANN401
    """Return a wheel as a plane face of OpenCASCADE, mm, with named edges: "fixed", "hole k",
    "contact k", and "free" for the others.
    """
    from netgen.occ import (
        ArcOfCircle,
        Circle,
        Compound,
        Dir,
        Face,
        Pnt,
        Segment,
        SplineInterpolation,
        Wire,
    )
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
    face = (
        fixed - toothed
        if blank.body.part == "ring"
        else toothed - Compound([fixed, *(disc(each.centre, each.radius) for each in blank.holes)])
    )
    circles = {"fixed": (blank.centre, blank.body.edge)} | {
        f"hole {k}": (hole.centre, hole.radius) for k, hole in enumerate(blank.holes)
    }
    own = [edge for edge in blank.outline if edge.contact >= 0]
    middles, chords = (
        np.array([edge.points.mean() for edge in own]),
        np.array([abs(edge.points[-1] - edge.points[0]) for edge in own]),
    )
    edges = list(face.edges)
    ends = np.array([[(end.x, end.y) for end in (edge.start, edge.end)] for edge in edges]) / MM
    ends = ends @ np.array([1, 1j])
    on_circle = {
        name: np.abs(np.abs(ends - centre) - radius).max(axis=1) < _SAME_PLACE
        for name, (centre, radius) in circles.items()
    }
    middle = ends.mean(axis=1)
    tree = KDTree(np.stack([middles.real, middles.imag], axis=-1))
    nearest = tree.query(np.stack([middle.real, middle.imag], axis=-1))
    off, near = (np.asarray(each) for each in nearest)
    names = [
        next((name for name, here in on_circle.items() if here[k]), "free")
        for k in range(len(edges))
    ]
    hit = 0
    for k, edge in enumerate(edges):  # names that are set before a boolean are lost
        if names[k] == "free" and off[k] < 0.1 * chords[near[k]]:
            names[k] = f"contact {own[near[k]].contact}"
            hit += 1
        edge.name = names[k]
    if hit != len(own) or set(names) < circles.keys():
        raise DidNotConvergeError(
            f"the outline has {hit} of {len(own)} pieces of contacts, or misses a circle"
        )
    return face
