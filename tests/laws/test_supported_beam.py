"""Beams on supports and foundations against closed forms."""

from __future__ import annotations

import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from lostmotion.laws.cross_sections import round_section
from lostmotion.laws.supported_beam import BeamPiece, Foundation, Support, SupportedBeam, respond

# A row of docs/validation.md each: quantity, compared with, agreement, other files.
VALIDATES = (
    (
        "shafts and pins on springs and foundations",
        "closed forms of beams; every part softened",
        "1e-5; always more compliant, by its own contribution to first order",
        "laws/supported_beam.py laws/cycloid/shaft.py tests/laws/test_cycloid_shaft.py",
    ),
)

STEEL = 210e9, 0.3


def bar(
    start: float,
    end: float,
    diameter: float,
    bore: float = 0.0,
    material: tuple[float, float] = STEEL,
) -> BeamPiece:
    """Return a piece of a round bar."""
    young, nu = material
    section = round_section(diameter, bore, nu)
    return BeamPiece(
        start, end, young * section.i_y, young / (2 + 2 * nu) * section.area * section.shear_y
    )


def at(place: float) -> tuple[float, float]:
    """Return a point load."""
    return place, place


def test_a_shaft_between_two_supports():
    """Steel, diameter 12 mm, span 50 mm, load at 16 mm: 1.05736e-5 mm/N, and reactions by the
    lever.
    """
    found = respond(
        SupportedBeam((bar(0, 0.05, 0.012),), (Support(0.0), Support(0.05))), [at(0.016)]
    )
    assert found.flexibility[0, 0] == pytest.approx(1.05736e-8, rel=1e-5)
    np.testing.assert_allclose(found.reactions[:, 0], [-34 / 50, -16 / 50], rtol=1e-9)


def test_a_shaft_that_overhangs():
    """Supports at 0 and 30 mm, load at 45 mm: 1.85681e-5 mm/N; the near support carries more than
    the load.
    """
    found = respond(
        SupportedBeam((bar(0, 0.045, 0.012),), (Support(0.0), Support(0.03))), [at(0.045)]
    )
    assert found.flexibility[0, 0] == pytest.approx(1.85681e-8, rel=1e-5)
    np.testing.assert_allclose(found.reactions[:, 0], [0.5, -1.5], rtol=1e-9)


def test_two_loads_on_a_shaft():
    """Span 60 mm, loads at 20 and 40 mm: opposite forces shift it by a sixth of what one alone
    does.
    """
    flexibility = respond(
        SupportedBeam((bar(0, 0.06, 0.012),), (Support(0.0), Support(0.06))), [at(0.02), at(0.04)]
    ).flexibility
    np.testing.assert_allclose(
        flexibility, [[1.82806e-8, 1.53780e-8], [1.53780e-8, 1.82806e-8]], rtol=1e-5
    )
    assert flexibility[0, 0] - flexibility[0, 1] == pytest.approx(2.90261e-9, rel=1e-5)


def test_a_rigid_shaft_on_springs():
    """20 N/µm at 0 and 60 mm: A11 2.7778e-5, A12 2.2222e-5 mm/N, all of it in the springs."""
    rigid = BeamPiece(0, 0.06, 1e12, 1e17)
    found = respond(
        SupportedBeam((rigid,), (Support(0.0, 2e7), Support(0.06, 2e7))), [at(0.02), at(0.04)]
    )
    np.testing.assert_allclose(found.flexibility, np.array([[5, 4], [4, 5]]) / 9 / 2e7, rtol=1e-4)
    assert found.by_part[0, 0, 0] < 1e-4 * found.flexibility[0, 0]


def test_a_cantilever_and_a_guided_beam():
    """L^3/(3 EI) + L/(k G A); clamped at both ends with the load in the middle L^3/(192 EI) + L/(4
    k G A); one end guided: 5/192 of L^3/EI.
    """
    piece, length = bar(0, 0.1, 0.01), 0.1
    bend, shear = length**3 / piece.bending, length / piece.shear
    clamp = Support(0.0, math.inf, math.inf)
    assert respond(SupportedBeam((piece,), (clamp,)), [at(length)]).flexibility[
        0, 0
    ] == pytest.approx(bend / 3 + shear, rel=1e-9)
    both = SupportedBeam((piece,), (clamp, Support(length, math.inf, math.inf)))
    assert respond(both, [at(length / 2)]).flexibility[0, 0] == pytest.approx(
        bend / 192 + shear / 4, rel=1e-9
    )
    guided = SupportedBeam((piece,), (clamp, Support(length, 0.0, math.inf)))
    assert respond(guided, [at(length / 2)]).flexibility[0, 0] == pytest.approx(
        bend * 5 / 192 + shear / 2, rel=1e-9
    )


def test_a_long_beam_on_an_elastic_foundation():
    """Hetenyi: a force on the end of a long beam shifts it by 2 lambda/k, in the middle by
    lambda/(2 k), lambda = (k/(4 EI))^(1/4); shear apart.
    """
    piece, k = BeamPiece(0, 1.0, 1.0, 1e9), 4e4  # lambda 10: ten lengths of decay
    beam = SupportedBeam((piece,), (), (Foundation(0, 1.0, k),))
    found = respond(beam, [at(0.0), at(0.5)])
    assert found.flexibility[0, 0] == pytest.approx(2 * 10 / k, rel=1e-3)
    assert found.flexibility[1, 1] == pytest.approx(10 / (2 * k), rel=1e-3)


def test_a_distributed_load_on_a_cantilever():
    """The mean shift under a uniform load is L^3/(20 EI) + L/(3 k G A)."""
    piece, length = bar(0, 0.1, 0.01), 0.1
    found = respond(SupportedBeam((piece,), (Support(0.0, math.inf, math.inf),)), [(0.0, length)])
    assert found.flexibility[0, 0] == pytest.approx(
        length**3 / (20 * piece.bending) + length / (3 * piece.shear), rel=1e-5
    )


def test_a_floating_foundation_transmits_no_force():
    """A rigid pin in a floating seat and on one spring: the spring carries all of the force, and
    the seat only hinders its tilt.
    """
    rigid = BeamPiece(0, 0.1, 1e6, 1e11)
    spring = Support(0.0, 1e7, 1e4)
    free, held = (
        respond(
            SupportedBeam((rigid,), (spring,), (Foundation(0.05, 0.1, 1e9, 1e3, floating),)),
            [at(0.1)],
        )
        for floating in (True, False)
    )
    np.testing.assert_allclose(free.reactions, [[-1.0]], rtol=1e-3)
    assert abs(held.reactions[0, 0]) < 0.5
    assert free.flexibility[0, 0] > held.flexibility[0, 0]


@settings(deadline=None)
@given(st.integers(0, 4), st.floats(0.1, 0.95), st.booleans())
def test_softening_any_part_softens_the_beam(part, factor, floating):
    """By the compliance of that part alone to first order, and never less than before; the parts'
    contributions add up and none is negative.
    """
    numbers = [1.0, 1.0, 1.0, 1.0, 1.0]
    found = []
    for each in (1.0, factor):
        numbers[part] = each
        one, two, near, far, seat = numbers
        pieces = (
            BeamPiece(0, 0.03, 200.0 * one, 1e7 * one),
            BeamPiece(0.03, 0.08, 60.0 * two, 5e6 * two),
        )
        foundation = Foundation(0.06, 0.08, 1e9 * seat, 1e4 * seat, floating)
        beam = SupportedBeam(
            pieces, (Support(0.0, 2e7 * near), Support(0.04, 3e7 * far, 500.0 * far)), (foundation,)
        )
        found.append(respond(beam, [at(0.02), (0.05, 0.055)]))
    stiff, soft = found
    np.testing.assert_allclose(stiff.flexibility, stiff.flexibility.T, rtol=1e-9)
    assert (
        np.linalg.eigvalsh(soft.flexibility - stiff.flexibility).min()
        >= -1e-9 * np.abs(stiff.flexibility).max()
    )
    assert (np.diagonal(stiff.by_part, axis1=1, axis2=2) >= 0).all()
    # softened by a hair, the whole follows the part's own contribution
    assert np.trace(soft.flexibility) <= np.trace(
        stiff.flexibility + stiff.by_part[part] * (1 / factor - 1)
    ) * (1 + 1e-9)


@pytest.mark.parametrize(
    ("beam", "why"),
    [
        (lambda: SupportedBeam((BeamPiece(0, 1, 1, 1), BeamPiece(2, 3, 1, 1))), "not consecutive"),
        (lambda: SupportedBeam((BeamPiece(0, 0, 1, 1),)), "no length"),
        (lambda: SupportedBeam((BeamPiece(0, 1, 0, 1),)), "no stiffness"),
        (lambda: SupportedBeam((BeamPiece(0, 1, 1, 1),), (Support(2.0),)), "beyond its ends"),
        (
            lambda: respond(
                SupportedBeam((BeamPiece(0, 1, 1, 1),), (Support(0.0), Support(1.0))), [(0.5, 2.0)]
            ),
            "beyond the ends",
        ),
        (
            lambda: respond(SupportedBeam((BeamPiece(0, 1, 1, 1),), (Support(0.5),)), [(0.5, 0.5)]),
            "do not hold",
        ),
        (lambda: respond(SupportedBeam((BeamPiece(0, 1, 1, 1),)), [(0.5, 0.5)]), "do not hold"),
    ],
)
def test_impossible_beams_are_refused(beam, why):
    """Gaps, no stiffness, places beyond the ends, and beams that can move freely."""
    with pytest.raises(ValueError, match=why):
        beam()


@pytest.mark.parametrize("away", [2.0**-54, 1e-15, 1e-12, 1e-9, 1e-7, 1e-5])
@pytest.mark.parametrize("beside", ["end", "support", "seat"])
def test_places_that_differ_by_rounding_are_one(away, beside):
    """A load so close to the beam's end, a support or a seat moves what one exactly there does, to
    the distance's own effect, and warns of nothing: without the small element between them.
    """
    there = {"end": 0.1, "support": 0.06, "seat": 0.03}[beside]
    beam = SupportedBeam(
        (bar(0, 0.06, 0.012), bar(0.06, 0.1, 0.01)),
        (Support(0.06, 3e8),),
        (Foundation(0.0, 0.03, 1e10, 1e5),),
    )
    near = there - max(away * there, math.ulp(there))
    found = respond(beam, [at(near), (near - 0.01, near)]).flexibility
    exact = respond(beam, [at(there), (there - 0.01, there)]).flexibility
    np.testing.assert_allclose(found, exact, rtol=100 * away + 3e-6)


def test_a_seat_or_piece_without_length_in_figures_is_refused():
    """Else it would vanish without a word: what is stiff or soft there is not in the sum."""
    pieces = bar(0, 0.1, 0.012), bar(0.1, 0.1 + 1e-9, 0.001)
    seat = Foundation(0.05, 0.05 + 1e-9, 1e17)
    held = Support(0.0, math.inf, math.inf)
    for beam in (SupportedBeam(pieces, (held,)), SupportedBeam(pieces[:1], (held,), (seat,))):
        with pytest.raises(ValueError, match="shorter than a millionth of the beam"):
            respond(beam, [at(0.08)])
