"""Outlines for drawings: corners on the true profile, chords within the stated distance of it."""

from __future__ import annotations

import math

import numpy as np
import pytest

from lostmotion.laws.cycloid.geometry import flank
from lostmotion.laws.cycloid.outline import chord_error, ring_outline, wheel_outline
from lostmotion.laws.cycloid.ring import ring_pitch
from lostmotion.laws.cycloid.stage import Modification, Stage

STAGES = {
    "rv": Stage(0.064, 0.003, 0.0013, 40),
    "arcs": Stage(0.034, 0.003, 0.0012, 16, "lobe arcs"),
    "envelope": Stage(0.05, 0.004, 0.0012, 24, "lobe envelope"),
    "planet pins": Stage(0.05, 0.004, 0.0012, 20, "planet pins"),
    "few pins": Stage(0.3, 0.04, 0.03, 5, "lobe arcs"),
}
MADE = Modification(20e-6, 5e-6)


def farthest(outline, dense, pitches):
    """Return the largest distance of points of the true curve from the closed polygon, by brute
    force over its sides within 2.5 pitches.
    """
    start = outline.points
    way = np.roll(start, -1, axis=0) - start
    middle = dense.mean(axis=0) @ [1, 1j]
    near = np.abs(np.angle(start @ [1, 1j] / middle)) < 2.5 * 2 * math.pi / pitches
    start, way = start[near], way[near]
    out = 0.0
    for few in np.array_split(dense, max(len(dense) * len(start) // 500_000, 1)):
        away = few[:, None] - start
        share = np.clip((away * way).sum(-1) / (way**2).sum(-1), 0, 1)
        out = max(
            out, float(np.linalg.norm(away - share[..., None] * way, axis=-1).min(axis=1).max())
        )
    return out


@pytest.mark.parametrize("name", STAGES)
@pytest.mark.parametrize("tolerance", [0.5e-6, 20e-6])
def test_chords_of_the_wheel_are_within_the_stated_error(name, tolerance):
    """Other points of the flank, over a tooth and a half, are within the stated error, and that
    within the tolerance.
    """
    stage = STAGES[name]
    outline = wheel_outline(stage, MADE, tolerance)
    t = np.linspace(0, 3 * math.pi / stage.lobes, 3001) + 1 / math.pi
    assert (
        farthest(outline, flank(stage, t, MADE)[0], stage.lobes) <= outline.chord_error <= tolerance
    )


@pytest.mark.parametrize("name", STAGES)
def test_corners_of_the_wheel_lie_on_the_true_flank(name):
    """Every corner is a point of the flank at some parameter: the nearest point of a dense, refined
    flank is within a nanometre.
    """
    stage = STAGES[name]
    outline = wheel_outline(stage, MADE, 5e-6)
    t = np.linspace(-math.pi, math.pi, 40 * 1024 + 1)
    points = flank(stage, t, MADE)[0]
    for corner in outline.points[:: max(len(outline.points) // 50, 1)]:
        at = t[np.linalg.norm(points - corner, axis=1).argmin()]
        fine = at + np.linspace(-1, 1, 2001) * (t[1] - t[0])
        assert chord_error(flank(stage, fine, MADE)[0], corner[None]) < 1e-9


@pytest.mark.parametrize("name", ["arcs", "envelope", "few pins"])
def test_chords_of_a_ring_with_lobes_are_within_the_stated_error(name):
    """Other points of the ring, whose profile has corners, are within the stated error, and that is
    within the tolerance.
    """
    stage = STAGES[name]
    outline = ring_outline(stage, 0.5e-6)
    assert farthest(outline, ring_pitch(stage, 5001), stage.pins) <= outline.chord_error <= 0.5e-6


def test_outlines_close_and_enclose_the_area():
    """The outline of a disc is closed and symmetric, and its area (shoelace formula) is that of the
    flank from a sum over a million points.
    """
    stage = STAGES["rv"]
    outline = wheel_outline(stage, MADE, 0.5e-6).points
    dense = flank(stage, np.linspace(0, 2 * math.pi, 1_000_000, endpoint=False), MADE)[0]

    def area(points):
        x, y = points.T
        return 0.5 * float((x * np.roll(y, -1) - y * np.roll(x, -1)).sum())

    assert area(outline) == pytest.approx(area(dense), rel=1e-5)
    mirrored = {(round(x * 1e9), round(-y * 1e9)) for x, y in outline}
    assert sum((round(x * 1e9), round(y * 1e9)) in mirrored for x, y in outline) > 0.9 * len(
        outline
    )


def test_a_coarser_drawing_has_fewer_corners():
    """With a hundred times the tolerance an outline has about a tenth of the corners, as chords of
    arcs have.
    """
    fine, coarse = (
        len(wheel_outline(STAGES["rv"], MADE, tolerance).points) for tolerance in (0.5e-6, 50e-6)
    )
    assert 6 < fine / coarse < 14


def test_chord_error_of_a_circle():
    """A polygon of n chords on a circle has the error R (1 - cos(pi/n))."""
    circle = np.stack([np.cos(x := np.linspace(0, 2, 100_001)), np.sin(x)], axis=-1)
    for chords in (10, 100):
        corners = circle[:: 100_000 // chords]
        assert chord_error(corners, circle) == pytest.approx(1 - math.cos(1 / chords), rel=1e-3)


def test_stages_without_an_outline_are_refused():
    """Stages with pins, whose wheels are circles, and turned flanks, which do not close, are
    refused.
    """
    with pytest.raises(ValueError, match="no ring with lobes"):
        ring_outline(STAGES["rv"], 1e-6)
    with pytest.raises(ValueError, match="step in the valley"):
        wheel_outline(STAGES["rv"], Modification(turn=1e-4), 1e-6)
