"""Stages with an envelope ring, drawn at random: rotation and pressure by contacts on elastic
bodies against contact by finite elements.

    python benchmarks/envelope_contact.py [--first 0] [--number 5]

Prints the rows of `ENVELOPES` in tests/validation/test_fem_cases.py, then both errors. Needs the
extra `fem`; 5 to 40 s per stage.
"""

from __future__ import annotations

import argparse
import math
from typing import TYPE_CHECKING

import numpy as np

from lostmotion.laws.contact import equivalent_modulus
from lostmotion.laws.cycloid.bodies import ElasticBody, ring_reach
from lostmotion.laws.cycloid.contact import Flanks
from lostmotion.laws.cycloid.drive import Drive, loaded_disc, nominal_gaps
from lostmotion.laws.cycloid.finite_elements.stage import loaded_stage
from lostmotion.laws.cycloid.stage import Stage

if TYPE_CHECKING:
    from collections.abc import Iterator

MATERIALS = {"steel": (210e9, 0.3), "aluminium": (70e9, 0.33), "polymer": (2.4e9, 0.38)}
# Peak pressure (Pa) of the first branch on rigid bodies, from which the torque follows with a
# random share.
RATED = {"steel": 1100e6, "aluminium": 350e6, "polymer": 25e6}
PAIRS = [
    ("steel", "steel"),
    ("aluminium", "steel"),
    ("steel", "aluminium"),
    ("polymer", "polymer"),
    ("polymer", "aluminium"),
    ("aluminium",) * 2,
]
RADIUS, WIDTH = 0.05, 0.01


def stages(random: np.random.Generator) -> Iterator[Stage]:
    """Yield feasible stages: 14 to 40 lobes, K1 from 0.41 to 0.79, pins of 0.35 to 0.85 of half a
    pitch.
    """
    while True:
        pins, shortening = int(random.integers(14, 41)), random.uniform(0.41, 0.79)
        roller = RADIUS * math.sin(math.pi / pins) * random.uniform(0.35, 0.85)
        try:
            stage = Stage(RADIUS, roller, shortening * RADIUS / pins, pins, "lobe envelope")
        except ValueError:
            continue
        if shortening < (pins - 2) / pins - 0.05:
            yield stage


def drawn(seed: int) -> tuple[tuple[str, str], Stage, ElasticBody, ElasticBody, float, float]:
    """Return materials, stage, disc, ring, crank angle (rad) and torque (N m) of one stage."""
    random = np.random.default_rng(seed)
    stage = next(stages(random))
    hub = (stage.ring_radius - stage.pin_radius - stage.eccentricity) * random.uniform(0.3, 0.75)
    outer = ring_reach(stage) + stage.eccentricity * math.exp(
        random.uniform(math.log(1.5), math.log(12))
    )
    pair = PAIRS[seed % len(PAIRS)]
    crank = random.uniform(0, 2 * math.pi / stage.pins)
    pressure = min(RATED[each] for each in pair) * math.exp(random.uniform(math.log(0.35), 0.0))
    disc, ring = (MATERIALS[each] for each in pair)
    force = pressure**2 * math.pi * stage.pin_radius * WIDTH / equivalent_modulus(*disc, *ring)
    torque = force * stage.planet_pitch_radius * stage.pins / 4
    return (
        pair,
        stage,
        ElasticBody("planet", hub, *disc),
        ElasticBody("ring", outer, *ring),
        crank,
        torque,
    )


def main() -> None:
    """Solve each stage by both methods."""
    asked = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    asked.add_argument("--first", type=int, default=0, help="first seed")
    asked.add_argument("--number", type=int, default=5, help="number of stages")
    given = asked.parse_args()
    for seed in range(given.first, given.first + given.number):
        pair, stage, disc, ring, crank, torque = drawn(seed)
        made = loaded_stage(stage, disc, ring, WIDTH, np.array([torque]), crank=crank)
        drive = Drive(
            stage,
            Flanks(WIDTH, equivalent_modulus(disc.young, disc.nu, ring.young, ring.nu)),
            disc_body=disc,
            ring_body=ring,
        )
        found = loaded_disc(
            drive, torque, np.array([crank]), nominal_gaps(drive, np.array([crank]))
        )
        size = [
            1e3 * each
            for each in (
                stage.ring_radius,
                stage.pin_radius,
                stage.eccentricity,
                disc.edge,
                ring.edge,
            )
        ]
        radius, roller, eccentricity, hub, outer = (float(f"{each:.6g}") for each in size)
        turned = math.degrees(made.rotation[0]) * 60
        row = (
            *pair,
            stage.pins,
            radius,
            roller,
            eccentricity,
            hub,
            outer,
            float(f"{crank:.6g}"),
            float(f"{torque:.6g}"),
            float(f"{turned:.5g}"),
        )
        errors = (
            f"rotation {found.rotation.item() / made.rotation[0] - 1:+.4f}, pressure "
            f"{found.pressures.max() / made.peak.max() - 1:+.3f}"
        )
        print(
            (
                f"{row},  # seed {seed}: {errors}; meshes differ by "
                f"{made.error[0] / made.rotation[0]:.4f}"
            ),
            flush=True,
        )


if __name__ == "__main__":
    main()
