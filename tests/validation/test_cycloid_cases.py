"""Published cycloidal stages: radii, play, ratios."""

from __future__ import annotations

import math

import pytest

from lostmotion.laws.cycloid import Modification, Stage, play, rv_ratio, undercut_limit, valley_radius

ARCMIN = math.pi / 10800
RV_80E = Stage(0.0775, 0.004, 0.0015, 40)


def test_radii_of_the_fourteen_pin_stage():
    """R 34, N 14, e 1.5 mm: the smallest convex radius of the locus is 8.6232 mm, its valley's 0.6500 mm."""
    stage = Stage(0.034, 0.004, 0.0015, 14)
    assert undercut_limit(0.034, 0.0015, 14) * 1e3 == pytest.approx(8.6232, abs=5e-5)
    assert valley_radius(stage) * 1e3 == pytest.approx(0.6500, abs=5e-5)


def test_play_of_the_forty_pin_stage():
    """R 77.5, Rr 4, e 1.5 mm, N 40: 10 um more on the roller gives 1.1753' of play, 10 um less on the pin circle 0.7439'."""
    assert play(RV_80E, Modification(roller=1e-5)) / ARCMIN == pytest.approx(1.1753, abs=5e-5)
    assert play(RV_80E, Modification(circle=1e-5)) / ARCMIN == pytest.approx(0.7439, abs=5e-5)


def test_ratios_of_published_reducers():
    """Planetary 9/27 with 40 lobes makes 121; the RV-80E, 10/38 with 40 pins of a possible geometry, 153."""
    assert rv_ratio(9, 27, 40) == 121
    assert rv_ratio(10, 38, RV_80E.pins) == 153
