"""An elastic wheel as a mesh of NGSolve: its displacements under pressure on the contacts, and its
stresses.

Lengths are in mm and stresses in MPa inside this file, because OpenCASCADE's tolerances are meant
for lengths of about one.

Source: J. Schöberl, C++11 implementation of finite elements in NGSolve, ASC report 30/2014, TU
Wien.
"""

from __future__ import annotations

import itertools
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, Final

import numpy as np

from lostmotion.errors import DidNotConvergeError
from lostmotion.laws.cycloid.finite_elements.elasticity import directions
from lostmotion.laws.cycloid.finite_elements.mesh import MM

if TYPE_CHECKING:
    import scipy.sparse

    from lostmotion.laws.cycloid.finite_elements.contours import Contacts
    from lostmotion.laws.cycloid.finite_elements.elasticity import Elasticity
    from lostmotion.laws.cycloid.finite_elements.envelope import EnvelopeContacts
    from lostmotion.laws.cycloid.finite_elements.mesh import Blank
    from lostmotion.spatial import Floats

# Points at which pressure is integrated over each interval of a contact.
_GAUSS: Final = 5
# Largest distance of a corner of the mesh from the end of an interval, as a share of it.
_OFF: Final = 0.02


@dataclass(frozen=True, slots=True)
class Field:
    """Displacement and stress of a wheel on its triangles, for pictures.

    points (point, 2), m; triangles (triangle, 3) point numbers; displacement (point, 2), m;
    von_mises (point,), Pa; strain (point,), equivalent strain: von Mises stress over 3 G
    """

    points: Floats
    triangles: np.ndarray[tuple[int, ...], np.dtype[np.int64]]
    displacement: Floats
    von_mises: Floats
    strain: Floats


class ElasticWheel:
    """A meshed wheel, with its response to pressure on the contacts.

    compliance (node, node), mm/MPa: mean gap that the pressure of one node opens at another, each
    weighted with its hat function
    sliding    (contact, node), mm/MPa: mean displacement along the tangent of each contact
    """

    def __init__(
        self,
        blank: Blank,
        law: Elasticity,
        made: Contacts | EnvelopeContacts,
        at: dict[int, Floats],
        mesh: Any,  # noqa: ANN401
        order: int,
    ) -> None:
        """Factorise the stiffness matrix and solve for the pressure of every node."""
        self._mesh, self._law = mesh, law
        if mesh.GetCurveOrder() != order:
            mesh.Curve(order)
        self._space = space = law.space(mesh, order, "" if blank.holes else "fixed")
        form = law.stiffness(space, blank.centre, sliding=bool(blank.holes))
        self._inverse = form.mat.Inverse(space.FreeDofs(), inverse="sparsecholesky")
        self._load, self._answer = form.mat.CreateColVector(), form.mat.CreateColVector()
        self._normal, tangent = _tractions(made, at, law, space, order)
        self._holes = _hole_loads(blank, law, space) if blank.holes else None
        self.compliance, self.sliding = self._responses(tangent, list(at.values()), made.moments)
        if not np.isfinite(self.compliance).all():
            raise DidNotConvergeError(
                "the stiffness matrix of a wheel is singular: a part of its mesh is not held"
            )

    def _responses(
        self, tangent: scipy.sparse.csr_array, places: list[Floats], moments: int
    ) -> tuple[Floats, Floats]:
        """Return the compliance and the sliding; `places` (node,) of each contact, m.

        At another contact a pressure acts by its force and its first `moments` - 1 moments alone,
        as far as the contact's width over the distance to the power of `moments` is negligible. So
        a few solves per contact, and one per node of all contacts at once, are enough.
        """
        ends = np.cumsum([0, *map(len, places)])
        mine = [slice(a, b) for a, b in itertools.pairwise(ends)]
        compliance, sliding = np.empty((ends[-1], ends[-1])), np.empty((len(places), ends[-1]))
        for own, each in zip(mine, places, strict=True):
            s = each / np.abs(each).max()
            powers = s ** np.arange(moments)[:, None]
            moved = []
            for power in powers:
                pressure = np.zeros(ends[-1])
                pressure[own] = power
                moved.append(self._displaced(pressure))
            far = np.array(moved).T
            # each hat as a polynomial with the same force and moments
            sums = powers @ _hat_products(MM * each)
            share = np.linalg.solve(sums @ powers.T, sums)
            compliance[:, own], sliding[:, own] = (
                (self._normal @ far) @ share,
                (tangent @ far) @ share,
            )
        for node in range(max(map(len, places))):
            here = [own.start + node for own in mine if node < own.stop - own.start]
            pressure = np.zeros(ends[-1])
            pressure[here] = 1.0
            found = self._normal @ self._displaced(pressure)
            of_all = compliance[:, here].sum(axis=1)
            for own in mine:
                if node < own.stop - own.start:
                    column = own.start + node
                    compliance[own, column] += found[own] - of_all[own]
        return (compliance + compliance.T) / 2, sliding

    def _displaced(self, pressure: Floats) -> Floats:
        """Return the unknowns (mm) under nodal pressures (node,), MPa."""
        load = self._normal.T @ pressure
        if self._holes is not None:  # the pins in the holes balance every load, to rounding
            turning, pins = self._holes
            load -= float(turning @ load) * pins
        self._load.FV().NumPy()[:] = load
        self._answer.data = self._inverse * self._load
        moved = np.asarray(self._answer.FV().NumPy().copy())
        if self._holes is not None:  # which do not turn on average
            moved -= float(pins @ moved) * turning
        return moved

    @property
    def size(self) -> int:
        """Return the number of elements."""
        return int(self._mesh.ne)

    @property
    def unknowns(self) -> int:
        """Return the number of unknowns."""
        return int(self._space.ndof * self._space.dim)

    def largest(self, pressure: Floats) -> tuple[float, float]:
        """Return the largest von Mises stress (Pa) and equivalent strain under nodal pressures
        (node,), Pa.
        """
        found = float(self._samples(pressure)[1].max())
        return found * MM**2, found / (3 * self._law.shear_modulus)

    def place_of_largest(self, pressure: Floats) -> complex:
        """Return the place (m) of the largest von Mises stress."""
        places, stress = self._samples(pressure)
        return complex(places[int(stress.argmax())] @ np.array([1, 1j])) / MM

    def _samples(self, pressure: Floats) -> tuple[Floats, Floats]:
        """Return the integration points (point, 2), mm, and the von Mises stress there, MPa."""
        import ngsolve as ng

        points = self._mesh.MapToAllElements(
            ng.IntegrationRule(ng.TRIG, 2 * self._space.globalorder), ng.VOL
        )
        places = ng.CoefficientFunction((ng.x, ng.y))(points)
        return np.asarray(places), np.asarray(self._von_mises(pressure)[1](points)).ravel()

    def field(self, pressure: Floats) -> Field:
        """Return displacement and stress at the corners of the elements; stresses are means over
        the elements that meet there.
        """
        import ngsolve as ng

        displacement, stress = self._von_mises(pressure)
        smooth = ng.GridFunction(ng.H1(self._mesh, order=1))
        smooth.Set(stress)
        points = np.array([vertex.point for vertex in self._mesh.vertices])
        triangles = np.array(
            [[vertex.nr for vertex in element.vertices] for element in self._mesh.Elements(ng.VOL)]
        )
        count = len(points)
        values = displacement.vec.FV().NumPy()
        corner = np.arange(count)
        moved = np.stack(
            [values[self._law.unknown(self._space, corner, axis)] for axis in range(2)], axis=-1
        )
        of_vertices = smooth.vec.FV().NumPy()[:count].copy()
        return Field(
            points / MM,
            triangles,
            moved / MM,
            of_vertices * MM**2,
            of_vertices / (3 * self._law.shear_modulus),
        )

    def _von_mises(self, pressure: Floats) -> tuple[Any, Any]:
        import ngsolve as ng

        displacement = ng.GridFunction(self._space)
        displacement.vec.FV().NumPy()[:] = self._displaced(pressure / MM**2)
        return displacement, self._law.von_mises(displacement)


def _hole_loads(blank: Blank, law: Elasticity, space: Any) -> tuple[Floats, Floats]:  # noqa: ANN401
    """Return the unknowns of a unit rotation about the wheel's centre, and the loads of pins in the
    holes that resist it with a unit moment.
    """
    import ngsolve as ng

    load = ng.LinearForm(space)
    for k, hole in enumerate(blank.holes):
        if hole.force:
            out = directions(hole.centre)[0]
            push = out * ng.CoefficientFunction((hole.force.real, hole.force.imag))
            load += (ng.IfPos(push, push, 0.0) * out * law.mean(space.TestFunction())) * ng.ds(
                f"hole {k}"
            )
    load.Assemble()
    turning, pins = law.rotation(space, blank.centre), load.vec.FV().NumPy().copy()
    return turning, pins / float(pins @ turning)


def gauss() -> tuple[Floats, Floats]:
    """Return the points and weights by which quantities are integrated over an interval from 0 to
    1.
    """
    x, weight = np.polynomial.legendre.leggauss(_GAUSS)
    return (x + 1) / 2, weight / 2


def _hat_products(s: Floats) -> Floats:
    """Return the integrals of the products of two hat functions on a grid s."""
    step = np.diff(s)
    out = np.diag(np.concatenate([step, [0.0]]) + np.concatenate([[0.0], step])) / 3
    inner = np.arange(len(step))
    out[inner, inner + 1] = out[inner + 1, inner] = step / 6
    return out


def _tractions(
    made: Contacts | EnvelopeContacts,
    at: dict[int, Floats],
    law: Elasticity,
    space: Any,  # noqa: ANN401
    order: int,
) -> tuple[scipy.sparse.csr_array, scipy.sparse.csr_array]:
    """Return the nodal forces of a unit pressure at each node (node, unknown), and those of the
    mean tangential displacement (contact, unknown).
    """
    import ngsolve as ng

    mesh = space.mesh
    scalar = ng.H1(mesh, order=order)
    row = {k: n for n, k in enumerate(at)}
    first = dict(zip(at, np.cumsum([0, *map(len, at.values())]).tolist(), strict=False))
    entries: tuple[list[tuple[int, Any, Floats]], ...] = [], []
    vertices = np.array([vertex.point for vertex in mesh.vertices]) @ np.array([1, 1j]) / MM
    x, weight = gauss()
    names = mesh.GetBoundaries()
    hit = set()
    for element in mesh.Elements(ng.BND):
        name = names[element.index]
        if not name.startswith("contact"):
            continue
        k = int(name.split()[1])
        here, there = made.along(k, vertices[[vertex.nr for vertex in element.vertices]])
        low = int(np.abs(at[k] - min(here, there)).argmin())
        step = at[k][low + 1] - at[k][low]
        if (
            max(abs(min(here, there) - at[k][low]), abs(max(here, there) - at[k][low + 1]))
            > _OFF * step
        ):
            raise DidNotConvergeError(
                f"no mesh fits the pressed width of contact {k}: "
                "a smaller torque, or another refinement of the mesh"
            )
        hit.add((k, low))
        number = ng.ElementId(ng.BND, element.nr)
        unknowns, shape = np.array(scalar.GetDofNrs(number)), scalar.GetFE(number)
        for at_x, w in zip(x, weight, strict=True):
            s = at[k][low] + at_x * step
            values = (
                w
                * step
                * MM
                * np.asarray(shape.CalcShape((s - there) / (here - there), 0, 0)).ravel()
            )
            outwards = made.normal(k, np.array([s]))[0]
            along = 1j * outwards / (MM * (at[k][-1] - at[k][0]))
            for axis, (out, turned) in enumerate(
                ((outwards.real, along.real), (outwards.imag, along.imag))
            ):
                own = law.unknown(space, unknowns, axis)
                for node, hat in ((low, 1 - at_x), (low + 1, at_x)):
                    entries[0].append((first[k] + node, own, hat * out * values))
                entries[1].append((row[k], own, turned * values))
    nodes = sum(map(len, at.values()))
    if len(hit) != nodes - len(at):
        raise DidNotConvergeError(
            f"the mesh has {len(hit)} of the {nodes - len(at)} intervals of the contacts"
        )
    normal, tangent = (
        _sparse(each, (count, space.ndof * space.dim))
        for each, count in zip(entries, (nodes, len(at)), strict=True)
    )
    return normal, tangent


def _sparse(
    entries: list[tuple[int, Any, Floats]], shape: tuple[int, int]
) -> scipy.sparse.csr_array:
    """Return a matrix of entries by row, columns and values; those of one place add."""
    import scipy.sparse

    rows = np.repeat([row for row, _, _ in entries], [len(values) for _, _, values in entries])
    columns, values = (np.concatenate([entry[k] for entry in entries]) for k in (1, 2))
    return scipy.sparse.csr_array((values, (rows, columns)), shape=shape)
