"""Tolerances by process, and the modulus of polymers over time and temperature, against tables and
data sheets.
"""

from __future__ import annotations

import itertools
import math
from typing import get_args

import pytest

from lostmotion.laws.polymers import HOUR, REFERENCE, creep_factor, temperature_factor
from lostmotion.laws.process_tolerance import Process, process_tolerance

# A row of docs/validation.md each: quantity, compared with, agreement, other files.
VALIDATES = (
    (
        "tolerances by process, creep of polymers",
        "ISO 2768-1 and ISO 286-1; data sheet of a polycarbonate",
        "printed digits",
        "laws/polymers.py laws/process_tolerance.py",
    ),
)


@pytest.mark.parametrize(
    ("process", "size", "tolerance"),
    [
        ("ISO 2768 f", 2.0, 0.05),
        ("ISO 2768 f", 30.0, 0.1),
        ("ISO 2768 m", 30.1, 0.3),
        ("ISO 2768 m", 120.0, 0.3),
        ("ISO 2768 m", 121.0, 0.5),
        ("ISO 2768 c", 5.0, 0.3),
        ("ISO 2768 c", 399.0, 1.2),
        ("ISO 2768 f", 401.0, 0.3),
        ("ISO 2768 m", 1000.0, 0.8),
        ("ISO 2768 m", 3000.0, 2.0),
        ("ISO 2768 c", 1500.0, 3.0),
        ("IT7", 40.0, 0.0125),
        ("IT6", 70.0, 0.0095),
        ("IT11", 20.0, 0.065),
        ("FFF", 34.0, 0.2),
        ("FFF", 200.0, 0.4),
        ("FFF industrial", 25.4, 0.1),
        ("SLS", 100.0, 0.2),
        ("MJF", 20.0, 0.13),
        ("SLA fine", 10.0, 0.05),
    ],
)
def test_tolerances_are_those_of_the_tables(process: str, size: float, tolerance: float):
    """Sizes in mm have the tolerances of ISO 2768-1, half the grades of ISO 286-1, or what print
    services state.
    """
    assert process_tolerance(process, size * 1e-3) == pytest.approx(tolerance * 1e-3, rel=1e-9)


def test_a_larger_dimension_is_never_made_more_exactly():
    """Tolerances do not fall with the size, in any process, and reach every size of a gearbox."""
    sizes = [0.5e-3 * 1.1**k for k in range(70)]
    for process in get_args(Process):
        found = [process_tolerance(process, size) for size in sizes if size < 0.4]
        assert all(second >= first > 0 for first, second in itertools.pairwise(found)), process
    for process, size, end in (("ISO 2768 m", 5.0, 4000), ("ISO 2768 f", 2.5, 2000)):
        with pytest.raises(
            ValueError,
            match=rf"no general tolerance of {process} at {size * 1e3:.0f} mm: up to {end} mm",
        ):
            process_tolerance(process, size)


def test_creep_of_polycarbonate_is_that_of_its_data_sheet():
    """Makrolon 2856: 2.40 GPa in a tensile test, creep modulus 2.20 GPa after 1 h and 1.90 GPa
    after 1 000 h (ISO 899-1).
    """
    factors = 2.20 / 2.40, 1.90 / 2.40
    assert creep_factor(30.0, *factors) == 1
    assert 2.40 * creep_factor(HOUR, *factors) == pytest.approx(2.20)
    assert 2.40 * creep_factor(1000 * HOUR, *factors) == pytest.approx(1.90)
    assert 2.40 * creep_factor(math.sqrt(1000) * HOUR, *factors) == pytest.approx(2.05)
    times = [60.0 * 2**k for k in range(40)]
    found = [creep_factor(time, *factors) for time in times]
    assert all(0 < later <= sooner <= 1 for sooner, later in itertools.pairwise(found))


def test_half_of_the_modulus_is_left_at_the_heat_deflection_temperature():
    """The modulus falls linearly from room temperature to half at the heat deflection temperature,
    above which none is stated.
    """
    deflection = REFERENCE + 122
    assert temperature_factor(REFERENCE - 30, deflection) == 1
    assert temperature_factor(REFERENCE + 61, deflection) == pytest.approx(0.75)
    assert temperature_factor(deflection, deflection) == pytest.approx(0.5)
    with pytest.raises(ValueError, match="above the heat deflection temperature"):
        temperature_factor(deflection + 1, deflection)
