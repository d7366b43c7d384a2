"""The eccentric's shaft under discs whose forces turn with their cranks."""

from __future__ import annotations

import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from lostmotion.laws.cycloid.shaft import (
    ShaftBolts,
    ShaftCompliance,
    ShaftLayer,
    Stretch,
    shaft_compliance,
)
from lostmotion.laws.supported_beam import Support, SupportedBeam, respond

# A row of docs/validation.md each: quantity, compared with, agreement, other files.
VALIDATES = (
    (
        "screws along a shaft",
        "closed form of a sandwich cantilever; finite elements",
        "3e-4; 6 %",
        "laws/cycloid/shaft.py",
    ),
)

STEEL = 210e9, 0.3
PLASTIC = 2.4e9, 0.36
RIGID = math.inf


def bar(
    start: float, end: float, diameter: float = 0.012, material: tuple[float, float] = STEEL
) -> Stretch:
    """Return a stretch of a solid bar."""
    return Stretch(start, end, (ShaftLayer(diameter, 0.0, *material),))


def found(
    stretches: list[Stretch],
    supports: list[Support],
    discs: list[float],
    eccentricity: float = 0.0,
    phases: np.ndarray | None = None,
) -> ShaftCompliance:
    """Return the compliance under point loads, evenly spaced in phase."""
    beam = SupportedBeam(tuple(each.piece for each in stretches), tuple(supports))
    around = 2 * math.pi * np.arange(len(discs)) / len(discs) if phases is None else phases
    return shaft_compliance(beam, stretches, [(each, each) for each in discs], around, eccentricity)


def test_one_disc_and_two_opposite_ones():
    """Span 60 mm: 1.82806e-5 mm/N for a disc at 20 mm; two opposite discs at 20 and 40 mm load the
    shaft by a couple and feel a sixth, 2.90261e-6.
    """
    ends = [Support(0.0), Support(0.06)]
    one = found([bar(0, 0.06)], ends, [0.02])
    assert one.total == pytest.approx(1.82806e-8, rel=1e-5)
    np.testing.assert_allclose(one.reactions, [2 / 3, 1 / 3], rtol=1e-9)
    two = found([bar(0, 0.06)], ends, [0.02, 0.04])
    assert two.total == pytest.approx(2.90261e-9, rel=1e-5)
    np.testing.assert_allclose(two.reactions, [1 / 3, 1 / 3], rtol=1e-9)
    in_phase = found([bar(0, 0.06)], ends, [0.02, 0.04], phases=np.zeros(2))
    assert in_phase.total == pytest.approx(1.82806e-8 + 1.53780e-8, rel=1e-5)


def test_a_rigid_shaft_on_springs_feels_its_supports():
    """20 N/um at 0 and 60 mm, discs at 20 and 40 mm: 2.7778e-5 mm/N for one, 5.556e-6 for two
    opposite ones, all of it in the springs.
    """
    rigid = [bar(0, 0.06, 1.0)]
    springs = [Support(0.0, 2e7), Support(0.06, 2e7)]
    assert found(rigid, springs, [0.02]).total == pytest.approx(2.7778e-8, rel=1e-4)
    two = found(rigid, springs, [0.02, 0.04])
    assert two.total == pytest.approx(5.5556e-9, rel=1e-4)
    assert two.by_part[1:].sum() == pytest.approx(two.total, rel=1e-4)


def test_a_core_on_the_axis_adds_its_stiffness():
    """Plastic of 12 mm, 30 mm long, clamped, around a steel core of 4 mm: 1.8122e-3 mm/N; 1.8153e-3
    by finite elements.
    """
    layers = (ShaftLayer(0.012, 0.004, *PLASTIC), ShaftLayer(0.004, 0.0, *STEEL))
    whole = found([Stretch(0.0, 0.03, layers)], [Support(0.0, RIGID, RIGID)], [0.03])
    assert whole.total * 1e3 == pytest.approx(1.8122e-3, rel=1e-3)
    assert whole.total * 1e3 == pytest.approx(1.8153e-3, rel=3e-3)
    assert (
        whole.total
        < found([Stretch(0.0, 0.03, layers[:1])], [Support(0.0, RIGID, RIGID)], [0.03]).total
    )


def test_torsion_between_the_discs():
    """A disc behind a length L of the shaft shifts by e^2 L/(G J) more; over two discs half of it,
    and the order of the discs is the same.
    """
    e, shaft = 1.5e-3, bar(0, 0.06)
    ends = [Support(0.0), Support(0.06)]
    twist = e**2 * 0.02 / shaft.torsion
    assert found([shaft], ends, [0.02, 0.04], e).twist == pytest.approx(twist / 2, rel=1e-12)
    assert found([shaft], ends, [0.04, 0.02], e).total == pytest.approx(
        found([shaft], ends, [0.02, 0.04], e).total, rel=1e-9
    )
    assert found([shaft], ends, [0.02], e).twist == 0.0
    torsion = shaft.layers[0].young / 2.6 * math.pi / 32 * 0.012**4
    assert shaft.torsion == pytest.approx(torsion, rel=1e-12)
    halves = [bar(0, 0.03), bar(0.03, 0.06, 0.006)]
    stepped = e**2 * (0.01 / halves[0].torsion + 0.01 / halves[1].torsion) / 2
    assert found(halves, ends, [0.02, 0.04], e).twist == pytest.approx(stepped, rel=1e-12)


@given(st.integers(0, 4), st.floats(0.2, 0.95), st.integers(1, 4), st.floats(0, 2 * math.pi))
def test_softening_any_part_softens_the_shaft(part, factor, discs, turn):
    """Sections, bearings; and turning all cranks together changes nothing."""
    places = [0.012 + 0.01 * k for k in range(discs)]
    answers = []
    for change in (1.0, factor):
        young = [210e9, 2e9, 210e9]
        springs = [3e7, 6e7]
        if part < len(young):
            young[part] *= change
        else:
            springs[part - 3] *= change
        ends = (0.0, 0.01, 0.03, 0.06)
        stretches = [bar(ends[k], ends[k + 1], 0.012, (young[k], 0.3)) for k in range(3)]
        phases = turn + 2 * math.pi * np.arange(discs) / discs
        answers.append(
            found(
                stretches,
                [Support(0.0, springs[0]), Support(0.06, springs[1])],
                places,
                1e-3,
                phases,
            )
        )
        plain = found(
            stretches, [Support(0.0, springs[0]), Support(0.06, springs[1])], places, 1e-3
        )
        assert answers[-1].total == pytest.approx(plain.total, rel=1e-9)
    assert answers[1].total > answers[0].total * (1 - 1e-12)
    assert (answers[0].by_part > -1e-20).all()


PAIR = ShaftBolts(2, 0.004, 0.0035, *STEEL)


def cantilever(
    direction: float, *, tight: bool, length: float = 0.03, screws: ShaftBolts = PAIR
) -> float:
    """Return the compliance (mm/N) of a clamped plastic bar of 12 mm with screws."""
    bar_with_screws = Stretch(0.0, length, (ShaftLayer(0.012, 0.0, *PLASTIC),), screws)
    beam = SupportedBeam(
        (bar_with_screws.piece_with_screws(direction, tight=tight),), (Support(0.0, RIGID, RIGID),)
    )
    return float(respond(beam, [(length, length)]).flexibility[0, 0]) * 1e3


def test_a_pair_of_screws_in_a_plastic_shaft():
    """Across their plane 1.1909e-3 mm/N (1.1864e-3 by finite elements); in it 3.242e-4 tight
    (3.461e-4), 1.316e-3 loose; composite 1.418e-4.
    """
    for tight in (True, False):
        assert cantilever(math.pi / 2, tight=tight) == pytest.approx(1.1909e-3, rel=1e-4)
    assert cantilever(0.0, tight=True) == pytest.approx(3.242e-4, rel=1e-3)
    assert cantilever(0.0, tight=True) == pytest.approx(3.461e-4, rel=0.07)
    assert cantilever(0.0, tight=False) == pytest.approx(1.316e-3, rel=1e-3)
    piece = Stretch(0.0, 0.03, (ShaftLayer(0.012, 0.0, *PLASTIC),), PAIR).piece_with_screws(
        0.0, tight=True
    )
    loose = Stretch(0.0, 0.03, (ShaftLayer(0.012, 0.0, *PLASTIC),), PAIR).piece_with_screws(
        0.0, tight=False
    )
    assert piece.second is not None
    composite = 0.03**3 / (3 * (piece.bending + piece.second[0])) + 0.03 / loose.shear
    assert composite * 1e3 == pytest.approx(1.418e-4, rel=1e-3)


@settings(deadline=None)
@given(st.floats(0.01, 0.2), st.floats(0.001, 0.0036), st.integers(2, 6))
def test_tight_screws_are_a_sandwich(length, diameter, count):
    """L^3/(3 EI) + (L/S)(1 - EI_f/EI)^2 (1 - tanh(q)/q) for any length, size and number (Allen
    1969).
    """
    screws = ShaftBolts(count, diameter, 0.004, *STEEL)
    piece = Stretch(0.0, length, (ShaftLayer(0.012, 0.0, *PLASTIC),), screws).piece_with_screws(
        0.0, tight=True
    )
    assert piece.second is not None
    faces, shear = piece.second
    whole = piece.bending + faces
    share = faces / whole
    q = length * math.sqrt(shear / (piece.bending * share))
    expected = length**3 / (3 * whole) + length / shear * share**2 * (1 - math.tanh(q) / q)
    assert cantilever(0.0, tight=True, length=length, screws=screws) * 1e-3 == pytest.approx(
        expected, rel=3e-3
    )


def test_three_screws_bend_equally_in_every_direction():
    """Evenly spaced, three or more have the same sum of squares all round; a pair has a stiff and a
    soft direction.
    """
    three = ShaftBolts(3, 0.003, 0.004, *STEEL)
    assert three.directions == (0.0,)
    assert cantilever(0.3, tight=True, screws=three) == pytest.approx(
        cantilever(1.1, tight=True, screws=three), rel=1e-9
    )
    assert len(PAIR.directions) == 2
    with pytest.raises(ValueError, match="within one layer"):
        Stretch(
            0.0, 0.03, (ShaftLayer(0.012, 0.004, *PLASTIC), ShaftLayer(0.004, 0.0, *STEEL)), PAIR
        )
