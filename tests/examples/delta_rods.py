"""A delta printer as six distances between balls: no tree, no closures and no Jacobian."""

from __future__ import annotations

import numpy as np
from scipy.optimize import root
from scipy.spatial.transform import Rotation

# Radius of the towers and of the balls on the hot end, half the distance between the rods of a
# pair, length of a rod, height of the nozzle: m. Towers at 0, 120 and 240 degrees.
RADIUS, INNER, HALF, ROD, HEIGHT = 0.14, 0.03, 0.025, 0.25, 0.075
TOWERS = [Rotation.from_rotvec([0, 0, angle]) for angle in np.radians([0, 120, 240])]
SIDES = (HALF, -HALF)
BALLS = np.array([tower.apply([INNER, side, 0]) for tower in TOWERS for side in SIDES])
# Points of the bed at which the printer is probed: its centre, and a circle about it.
AROUND, EDGE = np.arange(12) * np.pi / 6, 0.05
BED = [(0.0, 0.0), *((EDGE * np.cos(angle), EDGE * np.sin(angle)) for angle in AROUND)]
OFF, TURNED = 1e-4, np.radians(0.1)


def hot_end(heights, guess, *, radius=0.0, side=0.0, lean=0.0, yaw=0.0, rods=0.0):
    """Return place and rotation vector (6,) of the hot end: m, rad.

    heights  of the three carriages, m
    radius   by which the towers stand farther out, m; a number or three
    side     by which they stand farther along the circle, m
    lean     by which they lean outwards about their feet, rad
    yaw      by which their carriages turn about them, rad
    rods     by which the rods are too long, m; a number or six
    """
    turned = Rotation.from_rotvec
    out, along, leans, yaws = (np.broadcast_to(each, 3) for each in (radius, side, lean, yaw))
    carriages = []
    for k, tower in enumerate(TOWERS):
        for each in SIDES:
            on_tower = turned([0, 0, yaws[k]]).apply([0, each, 0]) + np.array([0, 0, heights[k]])
            foot = np.array([RADIUS + out[k], along[k], 0])
            carriages.append(tower.apply(foot + turned([0, leans[k], 0]).apply(on_tower)))

    def misfit(pose):
        balls = turned(pose[3:]).apply(BALLS) + pose[:3]
        return np.linalg.norm(balls - carriages, axis=1) - ROD - rods

    found = root(misfit, np.concatenate([guess, np.zeros(3)]), tol=1e-14)
    assert np.abs(found.fun).max() < 1e-12
    return found.x


def heights_at(x, y, z=HEIGHT):
    """Return the heights (3,) of the carriages with the nozzle at a point, m."""
    place = np.array([x, y, z])
    out = []
    for tower in TOWERS:
        away = tower.apply([RADIUS - INNER, 0, 0]) - place
        out.append(z + np.sqrt(ROD**2 - away[0] ** 2 - away[1] ** 2))
    return np.array(out)


FIRST = np.eye(3)[0]
CAUSES = {
    "end stop of tower A 0.1 mm high": {"stops": OFF * FIRST},
    "all end stops 0.1 mm high": {"stops": OFF},
    "tower A 0.1 mm too far out": {"radius": OFF * FIRST},
    "all towers 0.1 mm too far out (delta radius)": {"radius": OFF},
    "tower A 0.1 mm too far along the circle": {"side": OFF * FIRST},
    "tower A leans outwards by 0.1°": {"lean": TURNED * FIRST},
    "one rod of tower A 0.1 mm too long": {"rods": OFF * np.eye(6)[0]},
    "both rods of tower A 0.1 mm too long": {"rods": OFF * np.repeat(FIRST, 2)},
    "all rods 0.1 mm too long": {"rods": OFF},
    "carriage A turned by 0.1° about its tower": {"yaw": TURNED * FIRST},
}


def effects(stops=0.0, **cause):
    """Return what a cause does over the bed: height at the centre (µm), slope (µm per 100 mm),
    height of the edge above a plane through the centre (µm), tilt of the hot end at the centre
    (deg), and by how much 100 mm come out longer (µm).
    """
    moved = np.array(
        [
            hot_end(heights_at(x, y) + stops, (x, y, HEIGHT), **cause) - (x, y, HEIGHT, 0, 0, 0)
            for x, y in BED
        ]
    )
    height = moved[1:, 2]
    slope = 2 * np.hypot((height * np.cos(AROUND)).mean(), (height * np.sin(AROUND)).mean())
    outward = (moved[1:, 0] * np.cos(AROUND) + moved[1:, 1] * np.sin(AROUND)).mean()
    tilt = np.degrees(np.linalg.norm(moved[0, 3:]))
    centre = moved[0, 2]
    return (
        1e6 * centre,
        1e5 * slope / EDGE,
        1e6 * (height.mean() - centre),
        tilt,
        1e5 * outward / EDGE,
    )


def table():
    """Return the lines of the table at the head of the example's file."""
    lines = [
        (
            "| one error | height at the centre | slope over 100 mm | bowl: edge at 50 mm above the "
            "centre | tilt of the hot end | 100 mm printed become longer by |"
        ),
        "|---|---|---|---|---|---|",
    ]
    for name, cause in CAUSES.items():
        height, slope, bowl, tilt, scale = effects(**cause)
        cells = [f"{height:.0f} µm", f"{slope:.0f} µm", f"{bowl:.0f} µm", f"{tilt:.3f}°"]
        cells = [*cells, f"{scale:.0f} µm"]
        lines.append(f"| {name} | {' | '.join(cells)} |".replace(" -0 ", " 0 "))
    return lines
