"""How many contacts on elastic bodies per second, against the same equations in NumPy on the same
cases, in the same run?

The stage of docs/theory/cycloid.md (R 50, Rr 3, e 1.2, N 20, width 10 mm, steel, hub 20 mm, ring 60
mm), Johnson's law; torques 10 to 200 N m of either sign, 20 crank angles, drawn gearboxes whose
gaps scatter by 1 um.

    python benchmarks/elastic_contact.py [--cases 40000] [--numpy 300]

Contestants, alternating, best of three:
    NumPy           per case the approaches of all contacts and the rotation as unknowns, by
                    Newton's method with a halved step where the error grows one thread
                    lostmotion.laws.cycloid.contact.load_sharing
    two threads     the same, the batch cut in two
"""

from __future__ import annotations

import argparse
import math
import time

import numpy as np
from scipy.special import lambertw

from lostmotion.laws.contact import equivalent_modulus, johnson_scale
from lostmotion.laws.cycloid.bodies import ElasticBody, flexibility
from lostmotion.laws.cycloid.contact import Flanks, load_sharing
from lostmotion.laws.cycloid.geometry import arms, contact_radius, pin_angles
from lostmotion.laws.cycloid.stage import Stage

STAGE = Stage(0.05, 0.003, 0.0012, 20)
FLANKS = Flanks(0.01, equivalent_modulus(210e9, 0.3, 210e9, 0.3))
TORQUES = np.concatenate([-np.geomspace(10, 200, 5), np.geomspace(10, 200, 5)])
CRANKS = np.linspace(0, 2 * math.pi, 20, endpoint=False)
BODIES = sum(
    flexibility(STAGE, each, 0.01, CRANKS)
    for each in (ElasticBody("planet", 0.02, 210e9, 0.3), ElasticBody("ring", 0.06, 210e9, 0.3))
)
SOFT = 1 / (math.pi * FLANKS.modulus * FLANKS.width)


def pressed(approach: np.ndarray, scale: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Return forces (N) and stiffness (N/m) of Johnson's law, delta = F soft ln(B/F), by Lambert's
    W.
    """
    touching = approach > 0
    logarithm = -np.real(lambertw(-np.where(touching, approach / (SOFT * scale), 0.1), -1))
    return np.where(touching, approach / (SOFT * logarithm), 0.0), np.where(
        touching, 1 / (SOFT * (logarithm - 1)), 0.0
    )


def in_numpy(gaps: np.ndarray, cases: np.ndarray) -> np.ndarray:
    """Return the rotation of cases (case, 3), each (torque, crank, draw)."""
    theta = pin_angles(STAGE, CRANKS)
    arm, scale = (
        arms(STAGE, theta),
        johnson_scale(FLANKS.width, contact_radius(STAGE, theta), FLANKS.modulus),
    )
    out = np.full(len(cases), np.nan)
    for row, (i, j, k) in enumerate(cases):
        side, torque, soft = math.copysign(1.0, TORQUES[i]), abs(TORQUES[i]), BODIES[0, j]
        lever = side * arm[j]

        def left_over(
            unknown: np.ndarray, torque=torque, soft=soft, lever=lever, j=j, k=k
        ) -> tuple[np.ndarray, np.ndarray]:
            force, stiff = pressed(unknown[:-1], scale[j])
            error = np.append(
                unknown[:-1] + soft @ force - lever * unknown[-1] + gaps[k],
                (force @ lever - torque) * 1e-6 / torque,
            )
            slope = np.zeros((len(unknown), len(unknown)))
            slope[:-1, :-1] = np.eye(len(force)) + soft * stiff
            slope[:-1, -1], slope[-1, :-1] = -lever, stiff * lever * 1e-6 / torque
            return error, slope

        # every driving lobe touches
        turn = 1e-6 * torque + gaps[k].max() / STAGE.planet_pitch_radius
        unknown = np.append(0.5 * (lever * turn - gaps[k]), turn)
        error, slope = left_over(unknown)
        for _ in range(60):
            step, share = np.linalg.solve(slope, -error), 1.0
            while True:
                trial = unknown + share * step
                new, new_slope = left_over(trial)
                if np.linalg.norm(new) < np.linalg.norm(error) or share < 1e-3:
                    break
                share /= 2
            unknown, error, slope = trial, new, new_slope
            if np.abs(error).max() < 1e-17:
                out[row] = side * unknown[-1]
                break
    return out


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.partition("\n\n")[0])
    parser.add_argument("--cases", type=int, default=40_000)
    parser.add_argument("--numpy", type=int, default=300)
    options = parser.parse_args()
    rng = np.random.default_rng(1)
    draws = max(options.cases // (len(TORQUES) * len(CRANKS)), 1)
    gaps = 1e-6 * np.abs(rng.standard_normal((draws, STAGE.pins)))
    few = np.stack(
        [rng.integers(0, n, options.numpy) for n in (len(TORQUES), len(CRANKS), draws)], axis=1
    )
    load_sharing(STAGE, FLANKS, TORQUES[:1], CRANKS[:1], gaps[:1], bodies=BODIES[:, :1])  # compile
    cases = len(TORQUES) * len(CRANKS) * draws
    contestants = {
        "NumPy": (len(few), lambda: in_numpy(gaps, few)),
        "one thread": (
            cases,
            lambda: load_sharing(STAGE, FLANKS, TORQUES, CRANKS, gaps, bodies=BODIES),
        ),
        "two threads": (
            cases,
            lambda: load_sharing(STAGE, FLANKS, TORQUES, CRANKS, gaps, bodies=BODIES, threads=2),
        ),
    }
    best, results = dict.fromkeys(contestants, math.inf), {}
    for _ in range(3):
        for name, (count, contestant) in contestants.items():
            start = time.perf_counter()
            results[name] = contestant()
            best[name] = min(best[name], (time.perf_counter() - start) / count)
    ours, theirs = results["two threads"], results["NumPy"]
    print(
        f"{cases} contacts of {STAGE.pins} lobes on elastic bodies ({len(few)} for NumPy), "
        "best of three"
    )
    print(f"{'':12} {'us each':>10} {'per second':>12} {'times NumPy':>12}")
    for name, seconds in best.items():
        print(
            f"{name:12} {seconds * 1e6:10.2f} {1 / seconds:12.0f} {best['NumPy'] / seconds:12.0f}"
        )
    same, found = ours.rotation[tuple(few.T)], np.isfinite(theirs)
    print(
        f"NumPy found {found.sum()} of {len(few)}; where it did, the rotations differ by at "
        f"most {np.max(np.abs(theirs / same - 1)[found]):.1e}"
    )
    print(
        f"lostmotion converged on {ours.converged.mean():.2%}, largest residual "
        f"{ours.residual.max():.1e}"
    )


if __name__ == "__main__":
    main()
