"""Output pins in their seats, cages, needles and holes."""

from __future__ import annotations

import itertools
import math
from dataclasses import replace

import numpy as np
import pytest
from scipy.optimize import minimize

from lostmotion.laws.contact import equivalent_modulus
from lostmotion.laws.cycloid.output_pins import (
    ElasticPinSeat,
    HeldPin,
    Hole,
    largest_pin_force,
    needle_compliance,
    ring_share,
)

# A row of docs/validation.md each: quantity, compared with, agreement, other files.
VALIDATES = (
    (
        "output pins in elastic seats and cages",
        (
            "finite elements in three dimensions; closed forms of rigid seats; least energy of a "
            "floating ring"
        ),
        "-2 to +18 % of the compliance; 0.2 %; 0.2 %",
        "laws/cycloid/output_pins.py",
    ),
)

MM = 1e-3
# diameter, outer radius of the seat, its depth, free length (mm), E and nu of the seat: compliance
# by the law and by 3-D finite elements, mm/N
BONDED = [
    (5, 15, 10, 14, 2.4e9, 0.36, 7.53e-4, 6.40e-4),
    (5, 15, 5, 14, 2.4e9, 0.36, 1.412e-3, 1.430e-3),
    (8, 12, 12, 10, 2.4e9, 0.36, 1.411e-4, 1.211e-4),
    (6, 20, 20, 20, 70e9, 0.33, 3.279e-4, 2.849e-4),
]


def seat(
    depth: float, outer: float, young: float = 2.4e9, nu: float = 0.36, **more: object
) -> ElasticPinSeat:
    """Return a seat with depth and outer radius in mm."""
    return ElasticPinSeat(depth * MM, outer * MM, young, nu, **more)  # type: ignore[arg-type]


def cage(of_seat: float = 2.4e9, nu: float = 0.36, **more: object) -> HeldPin:
    """Return a pin of 5 mm between a flange (4 mm deep) and a ring (8 mm deep) 32 mm away, loaded
    from 2 to 29 mm.
    """
    near, far = (seat(depth, 8, of_seat, nu, **more) for depth in (4, 8))
    return HeldPin(5 * MM, 210e9, 0.3, 32 * MM, (2 * MM, 29 * MM), near, far, "ring")


@pytest.mark.parametrize("case", BONDED)
def test_a_cantilever_in_a_bonded_seat(case):
    """The law's figure, and three-dimensional finite elements within -2 and +18 %."""
    diameter, outer, depth, free, young, nu, law, finite = case
    pin = HeldPin(
        diameter * MM,
        210e9,
        0.3,
        free * MM,
        (free * MM, free * MM),
        seat(depth, outer, young, nu, fit="bonded"),
    )
    found = sum(pin.compliance()) * 1e3
    assert found == pytest.approx(law, rel=1e-3)
    assert 0.98 * finite < found < 1.18 * finite
    rigid, none = replace(pin, flange=None).compliance()
    assert none == 0.0
    assert rigid * 1e3 < found / (4 if young < 1e10 else 1.3)


def test_pins_in_a_floating_cage():
    """Two discs: 4.483e-4 mm/N bonded and 7.801e-4 with sliding sides, six and eight times that
    with the ring held; of steel 8.64e-5.
    """
    assert sum(cage(fit="bonded").compliance(2)) * 1e3 == pytest.approx(4.483e-4, rel=1e-3)
    held = replace(cage(fit="bonded"), held="both flanges")
    assert sum(held.compliance(2)) * 1e3 == pytest.approx(0.737e-4, rel=1e-3)
    sliding = cage(fit="pressed", adheres=False)
    assert sum(sliding.compliance(2)) * 1e3 == pytest.approx(7.801e-4, rel=1e-3)
    assert sum(replace(sliding, held="both flanges").compliance(2)) * 1e3 == pytest.approx(
        0.931e-4, rel=1.5e-3
    )
    assert sum(cage(210e9, 0.3, fit="bonded").compliance(2)) * 1e3 == pytest.approx(
        8.64e-5, rel=2e-3
    )


def test_a_floating_cage_of_rigid_seats():
    """Load in the middle: L^3/(EI) [1/192 + s/48] for a slender pin with the share s; loaded around
    the axis, each is a guided beam, 5/192.
    """
    length, diameter = 0.4, 5 * MM
    bend = length**3 / (210e9 * math.pi / 64 * diameter**4)
    pin = HeldPin(diameter, 210e9, 0.3, length, (length / 2, length / 2), None, None, "ring")
    for discs, share in ((1, ring_share(1, 4.0)), (2, 0.5), (3, 1.0), (5, 1.0)):
        assert sum(pin.compliance(discs)) == pytest.approx(bend * (1 / 192 + share / 48), rel=2e-3)
    assert pin.compliance(3)[0] == pytest.approx(bend * 5 / 192, rel=2e-3)


@pytest.mark.parametrize("gained", [1e-7, 1e-3, 0.3, 3.0, 10.0, 100.0])
@pytest.mark.parametrize("discs", [1, 2])
def test_a_floating_ring_moves_as_its_pins_push_it(gained, discs):
    """A ring on a spring at each pin finds the least energy in its three freedoms while pins push
    one way: the share of its motion over a pitch.

    At a unit rotation of the discs the torque is twice the energy, and n pins of a compliance C
    have n/4 of 1/C for one disc, n/2 for two.
    """
    pins = 24
    share = []
    for crank in 2 * math.pi / pins * (np.arange(6) + 0.5) / 6:
        psi = 2 * math.pi * np.arange(pins) / pins - crank
        sine, cosine = np.sin(psi), np.cos(psi)

        def energy(ring, sine=sine, cosine=cosine):
            shift, turn = ring[:2] / 100, ring[2]
            # the push is along x, on the side where it turns the ring forwards
            ahead = sine * (1 - turn) - shift[0]
            loaded = ahead if discs == 2 else np.maximum(ahead, 0.0)
            of_ring = (shift[0] + turn * sine) ** 2 + (shift[1] + turn * cosine) ** 2
            return float((loaded**2).sum() + (of_ring / max(gained, 1e-3)).sum()) / 2

        if gained < 1e-3:
            # a ring so stiff that it takes the forces of pins on a fixed ring
            force = np.maximum(sine, 0.0) if discs == 1 else sine
            compliance = 1 + gained * ((force @ sine) ** 2 + force.sum() ** 2) / pins / (
                force @ sine
            )
            share.append((compliance - 1) / gained)
            continue
        least = minimize(
            energy, np.array([0.1, 0.0, 0.1]), method="BFGS", options={"gtol": 1e-12}
        ).fun
        share.append((pins * discs / 4 / (2 * least) - 1) / gained)
    assert ring_share(discs, gained) == pytest.approx(np.mean(share), rel=2e-3)


def test_one_disc_shifts_its_ring():
    """With stiff pins 1/4 + 4/pi^2 of the motion, 0.57 to 0.63 with usual pins; two opposite discs
    only turn it, by a half.
    """
    assert ring_share(1, 1e-9) == pytest.approx(0.655, abs=5e-4)
    assert ring_share(1, 0.01) == pytest.approx(0.655, abs=2e-3)
    assert 0.55 < ring_share(1, 10.0) < ring_share(1, 3.0) < 0.64
    assert ring_share(2, 3.0) == 0.5


def test_three_discs_push_each_pin_around_the_axis():
    """Pushes max(0, sin) along each of many lines of centres add up to a force at right angles to
    the pin's radius.
    """
    lines = 2 * math.pi * np.arange(300) / 300
    push = np.maximum(np.sin(0.7 - lines), 0.0)
    whole = np.array([-(push * np.cos(lines)).sum(), -(push * np.sin(lines)).sum()])
    assert abs(whole @ [math.cos(0.7), math.sin(0.7)]) < 1e-3 * np.linalg.norm(whole)
    assert ring_share(3, 3.0) == 1.0


def test_softening_any_part_of_a_held_pin_softens_it():
    """Pin, seats, fit, a longer span, a thinner pin, one end free; a stiffer fit is stiffer."""
    pin = cage(fit="pressed")
    stiff = sum(pin.compliance())
    softer = [
        replace(pin, young=200e9),
        replace(pin, diameter=4.9 * MM),
        replace(pin, flange=seat(4, 8, 2.3e9)),
        replace(pin, ring=seat(8, 8, 2.3e9)),
        replace(pin, flange=seat(3.9, 8)),
        replace(pin, ring=seat(8, 8, fit="snug")),
        replace(pin, free=33 * MM),
        replace(pin, held="one end"),
    ]
    assert all(sum(each.compliance()) > stiff for each in softer)
    assert sum(cage(fit="bonded").compliance()) < stiff < sum(cage(fit="snug").compliance())


def test_impossible_pins_are_refused():
    """A seat inside the pin, a load beyond the free length."""
    with pytest.raises(ValueError, match="does not enclose a pin"):
        replace(cage(), flange=seat(4, 2.5)).compliance()
    with pytest.raises(ValueError, match="the discs push from"):
        replace(cage(), load=(2 * MM, 33 * MM))


def test_needles_stiffen_with_their_load():
    """Palmgren: with the force to the tenth, and with the length to 0.8; with their number to 0.9
    but for a ripple.
    """
    base = needle_compliance(100.0, 8, 0.02)
    assert needle_compliance(1000.0, 8, 0.02) == pytest.approx(base * 10**-0.1, rel=1e-6)
    assert needle_compliance(100.0, 8, 0.04) == pytest.approx(base * 2**-0.8, rel=1e-6)
    assert needle_compliance(100.0, 16, 0.02) == pytest.approx(base * 2**-0.9, rel=5e-3)


def test_a_pin_in_a_wide_hole_is_hertzian():
    """Ten times the force adds ln(10) of approach in the sum of both bodies' 1/(pi E' b), half of
    which is the hole's; small contacts only.
    """
    hole = Hole(6.2 * MM, 5 * MM, 10 * MM, 210e9, 0.3, 210e9, 0.3)
    modulus = equivalent_modulus(210e9, 0.3, 210e9, 0.3)
    softened = hole.compliance(10.0) - hole.compliance(100.0)
    assert softened == pytest.approx(math.log(10) / (math.pi * modulus * hole.width), rel=1e-6)
    soft = replace(hole, young=2.4e9, nu=0.36)
    assert soft.compliance(100.0) > 20 * hole.compliance(100.0)
    found = [soft.compliance(force) for force in (1.0, 10.0, 100.0, 1000.0)]
    assert found == sorted(found, reverse=True)


def test_a_contact_in_a_hole_is_continuous_where_it_becomes_wide():
    """The logarithm of narrow contacts goes over into the solution of wide ones without a step."""
    hole = Hole(6.05 * MM, 4.5 * MM, 8 * MM, 2.4e9, 0.36, 210e9, 0.3)
    found = [hole.compliance(10 ** (k / 50)) for k in range(151)]
    steps = [after / before for before, after in itertools.pairwise(found)]
    assert all(0.97 < step < 1.0 for step in steps)


def test_a_hole_as_small_as_its_pin_is_refused():
    """No clearance, no contact law."""
    with pytest.raises(ValueError, match="does not fit"):
        Hole(5 * MM, 5 * MM, 10 * MM, 210e9, 0.3, 210e9, 0.3)


def test_the_largest_force_on_a_pin():
    """Half of the pins, in proportion to their distance from the line of centres: 4 T/(Rw n_w); two
    discs share the torque.
    """
    assert largest_pin_force(100.0, 0.04, 8, 1) == pytest.approx(4 * 100 / (0.04 * 8))
    assert largest_pin_force(100.0, 0.04, 8, 2) == pytest.approx(2 * 100 / (0.04 * 8))
