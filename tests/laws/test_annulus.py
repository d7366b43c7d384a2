"""The elastic annulus against closed forms, an independent finite-element solution, and reciprocity
and energy of linear bodies.
"""

from __future__ import annotations

import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.sparse import coo_array
from scipy.sparse.linalg import splu

from lostmotion.laws.annulus import (
    CORNERED,
    ELLIPTIC,
    Annulus,
    edge_compliance,
    flexibility,
    spectrum,
)

# A row of docs/validation.md each: quantity, compared with, agreement, other files.
VALIDATES = (
    (
        "loaded annulus",
        (
            "torsion, Lamé, the half-plane and two rigid edges in closed form; finite elements on "
            "a polar grid"
        ),
        "1e-10; 1e-4; half-plane 1 to 2 %",
        "laws/annulus.py",
    ),
)

DISC = Annulus(0.047, 0.02, 0.01, 210e9, 0.3)
RING = Annulus(0.05, 0.06, 0.01, 210e9, 0.3)
BODIES = [
    DISC,
    RING,
    Annulus(0.047, 0.02, 0.01, 70e9, 0.33, "stress"),
    Annulus(0.05, 0.052, 0.01, 2e9, 0.45),
]


def annuli() -> st.SearchStrategy[Annulus]:
    """Discs and rings of any shape, Poisson's ratio and plane."""
    ratio = st.one_of(st.floats(0.1, 0.95), st.floats(1.05, 6.0))
    return st.builds(
        lambda loaded, share, nu, plane: Annulus(loaded, loaded * share, 0.01, 210e9, nu, plane),
        st.floats(0.01, 0.2),
        ratio,
        st.floats(-0.3, 0.45),
        st.sampled_from(["strain", "stress"]),
    )


def finite_elements(
    body: Annulus, angles: np.ndarray, half: float, across: int, around: int
) -> np.ndarray:
    """Return flexibilities (2 k, 2 k), radial then tangential, of half-elliptic loads: nine-node
    elements in x and y on a polar grid.
    """
    lam = (
        body.young
        * body.nu
        / ((1 + body.nu) * (1 - (2 * body.nu if body.plane == "strain" else body.nu)))
    )
    shear = body.young / (2 + 2 * body.nu)
    law = np.array([[lam + 2 * shear, lam, 0], [lam, lam + 2 * shear, 0], [0, 0, shear]])
    # row 0 is fixed, row 2 x across is loaded; elements are finer towards the load
    radius = (
        body.loaded + (body.fixed - body.loaded) * (1 - np.linspace(0, 1, 2 * across + 1)) ** 1.6
    )
    turn = 2 * math.pi * np.arange(2 * around) / (2 * around)
    x, y = radius[:, None] * np.cos(turn), radius[:, None] * np.sin(turn)
    number = np.arange(x.size).reshape(x.shape)
    i, j = np.meshgrid(np.arange(0, 2 * across, 2), np.arange(0, 2 * around, 2), indexing="ij")
    nodes = np.stack(
        [number[i + a, (j + b) % (2 * around)] for a in range(3) for b in range(3)], axis=-1
    ).reshape(-1, 9)
    gauss, weights = np.polynomial.legendre.leggauss(4)
    bend = lambda t: np.array([t * (t - 1) / 2, 1 - t * t, t * (t + 1) / 2])  # noqa: E731
    slope = lambda t: np.array([t - 0.5, -2 * t, t + 0.5])  # noqa: E731
    stiff = np.zeros((len(nodes), 18, 18))
    points = np.stack([x.ravel()[nodes], y.ravel()[nodes]], axis=-1)
    for s, ws in zip(gauss, weights, strict=True):
        for t, wt in zip(gauss, weights, strict=True):
            local = np.stack(
                [np.outer(slope(s), bend(t)).ravel(), np.outer(bend(s), slope(t)).ravel()]
            )
            jacobian = local @ points
            size = np.linalg.det(jacobian)
            grad = np.linalg.solve(jacobian, np.broadcast_to(local, (len(nodes), 2, 9)))
            strain = np.zeros((len(nodes), 3, 18))
            strain[:, 0, 0::2] = strain[:, 2, 1::2] = grad[:, 0]
            strain[:, 1, 1::2] = strain[:, 2, 0::2] = grad[:, 1]
            stiff += (ws * wt * np.abs(size))[:, None, None] * (
                strain.swapaxes(1, 2) @ law @ strain
            )
    dofs = np.stack([2 * nodes, 2 * nodes + 1], axis=-1).reshape(-1, 18)
    where = np.repeat(dofs, 18, axis=1).ravel(), np.tile(dofs, (1, 18)).ravel()
    matrix = coo_array((stiff.ravel(), where), shape=(2 * x.size, 2 * x.size)).tocsc()
    loads = np.zeros((2 * x.size, 2 * len(angles)))
    # consistent nodal loads of a half-ellipse, by Gauss-Chebyshev quadrature of the second kind on
    # the quadratic edges
    steps = np.arange(1, 65) * math.pi / 65
    for k, angle in enumerate(angles):
        place = (angle + half * np.cos(steps)) / (2 * math.pi / around)
        share = 2 / 65 * np.sin(steps) ** 2
        first = 2 * np.floor(place).astype(int)
        for column in range(3):
            node = number[-1, (first + column) % (2 * around)]
            part = share * bend(2 * (place - np.floor(place)) - 1)[column]
            phase = angle + half * np.cos(steps)
            ways = (np.cos(phase), -np.sin(phase)), (np.sin(phase), np.cos(phase))
            for axis, (radial, tangential) in enumerate(ways):
                np.add.at(loads[:, k], 2 * node + axis, part * radial)
                np.add.at(loads[:, len(angles) + k], 2 * node + axis, part * tangential)
    free = np.arange(2 * number.shape[1], 2 * x.size)
    moved = splu(matrix[free][:, free]).solve(loads[free])
    return np.asarray(loads[free].T @ moved / body.width)


def both_ways(
    body: Annulus,
    angles: np.ndarray,
    half: float,
    exponent: float = ELLIPTIC,
    harmonics: int | None = None,
) -> np.ndarray:
    """Return radial then tangential unit forces at each angle."""
    slants = np.repeat([0.0, math.pi / 2], len(angles))
    return flexibility(body, np.tile(angles, 2), slants, half, exponent, harmonics)


@pytest.mark.parametrize("body", BODIES)
def test_torsion_is_the_closed_form(body: Annulus):
    """A uniform tangential traction turns the edge by T/(4 pi G b) |1/a^2 - 1/c^2|."""
    turned = edge_compliance(body, 0)[0, 1, 1] / body.loaded  # rad/Pa
    torque = 2 * math.pi * body.loaded**2 * body.width
    shear = body.young / (2 + 2 * body.nu)
    assert turned / torque == pytest.approx(
        abs(body.fixed**-2 - body.loaded**-2) / (4 * math.pi * shear * body.width), rel=1e-12
    )


@pytest.mark.parametrize("body", BODIES)
def test_uniform_radial_traction_is_lames(body: Annulus):
    """Lamé: u = B (r - h^2/r), zero at the fixed radius h, under unit radial traction on the loaded
    edge, for plane stress and plane strain.
    """
    r, h, nu = body.loaded, body.fixed, body.nu
    slope, hoop = 1 + (h / r) ** 2, 1 - (h / r) ** 2
    if body.plane == "strain":
        stress = body.young / ((1 + nu) * (1 - 2 * nu)) * ((1 - nu) * slope + nu * hoop)
    else:
        stress = body.young / (1 - nu**2) * (slope + nu * hoop)
    outwards = 1 if r > h else -1
    assert edge_compliance(body, 0)[0, 0, 0] == pytest.approx(
        outwards * r * hoop / stress, rel=1e-12
    )


@pytest.mark.parametrize(
    "body", [*BODIES, Annulus(0.02, 0.03, 0.01, 3e6, 0.5), Annulus(0.03, 0.02, 0.01, 3e6, 0.5)]
)
def test_a_bonded_bush_is_the_closed_form(body: Annulus):
    """Both edges rigid, one shifted: K/b = 2 pi (1 + k) G/[k ln m - (m^2 - 1)/(k (m^2 + 1))], m the
    radii's ratio.

    For k = 1, incompressible, it is 4 pi G/[ln m - (m^2 - 1)/(m^2 + 1)]:
    the long rubber bush of J. Adkins and A. Gent, Brit. J. Appl. Phys. 5 (1954) 354.
    """
    m = max(body.loaded, body.fixed) / min(body.loaded, body.fixed)
    k, shear = body.kolosov, body.young / (2 + 2 * body.nu)
    expected = 2 * math.pi * (1 + k) * shear / (k * math.log(m) - (m**2 - 1) / (k * (m**2 + 1)))
    # a unit displacement is u_-1 = 1 only; the resultant is 2 pi r q_-1
    traction = np.linalg.solve(edge_compliance(body, 1)[1], [0.0, 1.0])
    assert 2 * math.pi * body.loaded * traction[1] == pytest.approx(expected, rel=1e-10)


@pytest.mark.parametrize("body", BODIES)
def test_a_traction_of_short_wavelength_deforms_a_half_plane(body: Annulus):
    """A traction of short wavelength moves a half-plane by 2 q/(E' k), k = 2 pi/wavelength,
    normally and tangentially.
    """
    n = 400
    own = edge_compliance(body, n)[n]
    half_plane = 2 * body.loaded / (body.plane_modulus * n)
    assert own[0, 0] + own[1, 1] == pytest.approx(2 * half_plane, rel=0.01)
    normal_and_tangential = np.linalg.eigvalsh(own)
    # normal and tangential compliance of a half-plane are coupled: 2/E' on the diagonal, (1 -
    # plane_nu)/E' beside it
    coupling = (1 - body.plane_nu) * body.loaded / (body.plane_modulus * n)
    np.testing.assert_allclose(
        normal_and_tangential, half_plane - coupling * np.array([1, -1]), rtol=0.02
    )


@pytest.mark.parametrize("body", BODIES[:3])
def test_finite_elements_agree(body: Annulus):
    """Compliances for radial and tangential loads at five positions agree with finite elements on a
    polar grid.
    """
    angles, half = np.array([0.1, 0.35, 1.2, 2.9, 4.4]), 0.12
    ours, theirs = both_ways(body, angles, half), finite_elements(body, angles, half, 16, 240)
    assert np.abs(ours - theirs).max() < 1e-4 * np.abs(ours).max()


@pytest.mark.parametrize("exponent", [ELLIPTIC, 0.0, CORNERED])
@pytest.mark.parametrize("body", BODIES)
def test_the_sum_over_harmonics_has_converged(body: Annulus, exponent: float):
    """The default of 200 harmonics agrees with 24 000 to 3e-4 of the largest entry, for Hertz's
    half-ellipse to 3e-6.
    """
    angles = np.array([0.0, 0.3, 1.2, 2.9])
    few, many = (both_ways(body, angles, 0.1, exponent, count) for count in (None, 24000))
    assert np.abs(few - many).max() < (3e-6 if exponent == ELLIPTIC else 3e-4) * np.abs(many).max()


@pytest.mark.parametrize("exponent", [ELLIPTIC, 0.0, CORNERED])
def test_spectrum_is_the_loads_fourier_transform(exponent: float):
    """The spectrum of a load is its Fourier integral of (1 - x^2)^exponent cos(n x), by
    Gauss-Jacobi quadrature.
    """
    from scipy.special import roots_jacobi

    x, weight = roots_jacobi(60, exponent, exponent)
    phase = np.array([0.0, 1e-9, 0.5, 3.0, 20.0])
    np.testing.assert_allclose(
        spectrum(phase, exponent), np.cos(np.outer(phase, x)) @ weight / weight.sum(), atol=1e-12
    )


def test_stress_at_a_square_inner_corner():
    """The exponent at a square inner corner satisfies Williams' condition for 270 degrees, sin(3 pi
    s/2) = s.
    """
    s = CORNERED + 1
    assert math.sin(1.5 * math.pi * s) == pytest.approx(s, abs=1e-9)


@settings(max_examples=60, deadline=None)
@given(
    annuli(),
    st.lists(st.floats(-3.1, 3.1), min_size=3, max_size=3),
    st.lists(st.floats(-3.1, 3.1), min_size=3, max_size=3),
    st.floats(0.05, 0.5),
)
def test_every_body_is_reciprocal_and_stores_energy(
    body: Annulus, angles: list[float], slants: list[float], half: float
):
    """Compliances are symmetric (Maxwell, Betti) and positive for each harmonic, and inversely
    proportional to the modulus.
    """
    own = edge_compliance(body, 40)
    np.testing.assert_allclose(own, own.swapaxes(1, 2), rtol=1e-6, atol=1e-6 * np.abs(own).max())
    flexible = flexibility(body, np.array(angles), np.array(slants), half)
    assert np.linalg.eigvalsh(flexible).min() > -1e-9 * flexible.max()
    harder = Annulus(body.loaded, body.fixed, 2 * body.width, 3 * body.young, body.nu, body.plane)
    np.testing.assert_allclose(
        6 * flexibility(harder, np.array(angles), np.array(slants), half),
        flexible,
        rtol=1e-9,
        atol=1e-12 * flexible.max(),
    )


@settings(max_examples=60, deadline=None)
@given(annuli(), st.floats(0.1, 0.95), st.floats(-1.5, 1.5))
def test_a_larger_fixed_region_is_never_softer(body: Annulus, share: float, slant: float):
    """Moving the fixed edge towards the loaded one constrains material that was free: every force
    deflects its own point less.
    """
    nearer = Annulus(
        body.loaded,
        body.loaded + share * (body.fixed - body.loaded),
        body.width,
        body.young,
        body.nu,
        body.plane,
    )
    before, after = (
        flexibility(each, np.array([0.0]), np.array([slant]), 0.1)[0, 0] for each in (body, nearer)
    )
    assert after < before * (1 + 1e-9)


def test_impossible_annuli_are_refused_with_all_reasons():
    """Impossible values are refused, each one named once."""
    with pytest.raises(ValueError, match=r"width is -1.*Poisson's ratio is 0\.6.*plane is 'bent'"):
        Annulus(0.05, 0.06, -1, 210e9, 0.6, "bent")  # type: ignore[arg-type]
    with pytest.raises(ValueError, match="two radii are the same"):
        Annulus(0.05, 0.05, 0.01, 210e9, 0.3)
    with pytest.raises(ValueError, match="angle and its slant"):
        flexibility(DISC, np.zeros(2), np.zeros(3), 0.1)
    with pytest.raises(ValueError, match="wider than zero"):
        flexibility(DISC, np.zeros(2), np.zeros(2), 0.0)
