"""Strains and stiffness of a wheel on its plane mesh: in plane strain, in plane stress, or extruded
over its width in three dimensions.

In three dimensions both faces are free. Displacements in the plane are sums of the even Legendre
polynomials of zeta = 2z/b, displacements across it of the odd ones, for loads are the same on both
sides of the middle plane. The coefficients are fields on the plane mesh: one layer of prisms of
high order over half the width. With one term (uniform in the plane, linear across it) it is Kane
and Mindlin's theory. Lengths in mm, stresses in MPa.

Source: T. Kane, R. Mindlin, J. Appl. Mech. 23 (1956) 277 (extension of plates of finite thickness).
"""

from __future__ import annotations

import functools
import operator
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, Final

import numpy as np
from numpy.polynomial.legendre import Legendre, leggauss

from lostmotion.laws.cycloid.finite_elements.mesh import MM

if TYPE_CHECKING:
    from collections.abc import Iterator

    from lostmotion.laws.cycloid.bodies import ElasticBody
    from lostmotion.spatial import Floats

# Stiffness of a bore that slides on its bearing, across and along its edge, in units of Young's
# modulus over its radius.
_RIGID: Final = 1e5
_LOOSE: Final = 1e-6
# Most terms with which the unknowns of one place are a block of the stiffness: NGSolve has blocks
# of up to three, whose factorisation takes a third of the time of single unknowns.
_BLOCKED: Final = 1


@dataclass(frozen=True, slots=True)
class Elasticity:
    """The elastic law of a wheel per width: plane as its body states, or in three dimensions.

    body   its modulus, Poisson's ratio and, without terms, its stress state
    width  b, m
    terms  of the displacements over the width; zero: plane
    """

    body: ElasticBody
    width: float
    terms: int = 0

    @property
    def shear_modulus(self) -> float:
        """Return the shear modulus, MPa."""
        return self.body.young / MM**2 / (2 + 2 * self.body.nu)

    @property
    def _lame(self) -> float:
        nu = self.body.nu
        return self.body.young / MM**2 * nu / ((1 + nu) * (1 - 2 * nu))

    def space(self, mesh: Any, order: int, fixed: str) -> Any:  # noqa: ANN401 - NGSolve publishes no types
        """Return the space of displacements: without terms, or with one, of vectors at every
        unknown of the mesh, so that the stiffness is a matrix of small blocks.
        """
        import ngsolve as ng

        if self.terms <= _BLOCKED:
            return ng.H1(mesh, order=order, dirichlet=fixed, dim=2 + self.terms)
        plane = ng.VectorH1(mesh, order=order, dirichlet=fixed)
        return ng.FESpace([plane, ng.H1(mesh, order=order, dirichlet=fixed)] * self.terms)

    def unknown(self, space: Any, number: Any, axis: int) -> Any:  # noqa: ANN401
        """Return the unknowns of the mean displacement along an axis, x or y, at numbers of the
        scalar space of the same mesh and order.
        """
        if self.terms <= _BLOCKED:
            return number * space.dim + axis
        return number + axis * (space.components[0].ndof // 2)

    def mean(self, displacement: Any) -> Any:  # noqa: ANN401
        """Return the mean displacement in the plane of an element of the space."""
        return self._parts(displacement)[0][0]

    def rotation(self, space: Any, centre: complex) -> Floats:  # noqa: ANN401
        """Return the unknowns of a unit rotation about a centre (m)."""
        import ngsolve as ng

        found = ng.GridFunction(space)
        turned = (MM * centre.imag - ng.y, ng.x - MM * centre.real)
        if self.terms <= _BLOCKED:
            found.Set(ng.CoefficientFunction((*turned, 0.0)[: space.dim]))
        else:
            found.components[0].Set(ng.CoefficientFunction(turned))
        return np.asarray(found.vec.FV().NumPy().copy())

    def stiffness(self, space: Any, centre: complex, *, sliding: bool) -> Any:  # noqa: ANN401
        """Return the bilinear form of the strain energy per width; a `sliding` bore (centre in m)
        adds its rigid bearing.
        """
        import ngsolve as ng

        u, v = space.TnT()
        form = ng.BilinearForm(space, symmetric=True)
        for zeta, weight in self._layers():
            (of_u, shear_u), (of_v, shear_v) = (self._strains(each, zeta) for each in (u, v))
            normal = self._lame * sum(of_u) * sum(of_v) + 2 * self.shear_modulus * sum(
                a * b for a, b in zip(of_u, of_v, strict=True)
            )
            shear = (
                4 * self.shear_modulus * sum(a * b for a, b in zip(shear_u, shear_v, strict=True))
            )
            form += weight * (normal + shear) * ng.dx
        if sliding:
            out, along = directions(centre)
            stiff = self.body.young / MM**2 / (MM * self.body.edge)
            parts = ([each for each, _ in self._parts(of)[::2]] for of in (u, v))
            for k, (a, b) in enumerate(zip(*parts, strict=True)):
                form += (
                    stiff
                    / (4 * k + 1)
                    * (_RIGID * (a * out) * (b * out) + _LOOSE * (a * along) * (b * along))
                    * ng.ds("fixed")
                )
        form.Assemble()
        return form

    def von_mises(self, displacement: Any) -> Any:  # noqa: ANN401
        """Return the von Mises stress in the middle plane, MPa."""
        import ngsolve as ng

        normal, shear = self._strains(displacement, 0.0)
        x, y, z = (2 * self.shear_modulus * each for each in normal)
        of_shear = sum((2 * self.shear_modulus * each) ** 2 for each in shear)
        return ng.sqrt(0.5 * ((x - y) ** 2 + (y - z) ** 2 + (z - x) ** 2) + 3 * of_shear)

    def _layers(self) -> Iterator[tuple[float, float]]:
        """Yield places zeta over half the width, with weights that integrate the energy exactly."""
        if not self.terms:
            yield 0.0, 1.0
            return
        for zeta, weight in zip(*leggauss(2 * self.terms), strict=True):
            if zeta > 0:
                yield float(zeta), float(weight)

    def _parts(self, displacement: Any) -> list[tuple[Any, Any]]:  # noqa: ANN401
        """Return the fields of a displacement and their gradients: by turns in the plane and across
        it.
        """
        import ngsolve as ng

        if self.terms > _BLOCKED:
            # a proxy is a list already, a function is not
            parts = getattr(displacement, "components", displacement)
            return [(each, ng.Grad(each)) for each in parts]
        slope = ng.Grad(displacement)
        if not self.terms:
            return [(displacement, slope)]
        return [(displacement[:2], slope[:2, :]), (displacement[2], slope[2, :])]

    def _strains(self, displacement: Any, zeta: float) -> tuple[list[Any], list[Any]]:  # noqa: ANN401
        """Return the strains along x, y, z, and the shear strains xy (and xz, yz), half the change
        of angle, at a place over the width.
        """
        parts = self._parts(displacement)
        inner = _sum(slope * _legendre(2 * k, zeta) for k, (_, slope) in enumerate(parts[::2]))
        x, y, shear = inner[0, 0], inner[1, 1], (inner[0, 1] + inner[1, 0]) / 2
        if not self.terms:
            nu = self.body.nu
            across = 0.0 if self.body.plane == "strain" else -nu / (1 - nu)
            return [x, y, across * (x + y)], [shear]
        half = MM * self.width / 2
        z = _sum(
            each * (_legendre(2 * k + 1, zeta, 1) / half) for k, (each, _) in enumerate(parts[1::2])
        )
        along_z = _sum(
            each * (_legendre(2 * k, zeta, 1) / half) for k, (each, _) in enumerate(parts[::2])
        )
        slope = _sum(slope * _legendre(2 * k + 1, zeta) for k, (_, slope) in enumerate(parts[1::2]))
        return [x, y, z], [shear, *((slope[axis] + along_z[axis]) / 2 for axis in range(2))]


def _legendre(degree: int, zeta: float, derivative: int = 0) -> float:
    return float(Legendre.basis(degree).deriv(derivative)(zeta))


def _sum(terms: Iterator[Any]) -> Any:  # noqa: ANN401
    """Return the sum of tensors, which no number can begin."""
    return functools.reduce(operator.add, terms)


def directions(centre: complex) -> tuple[Any, Any]:
    """Return the unit vectors away from a centre (m) and along the circles about it."""
    import ngsolve as ng

    x, y = ng.x - MM * centre.real, ng.y - MM * centre.imag
    radius = ng.sqrt(x * x + y * y)
    return ng.CoefficientFunction((x / radius, y / radius)), ng.CoefficientFunction(
        (-y / radius, x / radius)
    )
