"""How many loaded cycloidal contacts per second, against a loop over SciPy's root finder on the
same cases, in the same run?

A stage of 40 pins (R 77.5, Rr 4, e 1.5, width 15 mm, steel), Johnson's law, bearing of 300 N/um,
output pins; torques 10 to 800 N m of either sign, 100 crank angles, drawn gearboxes whose gaps
scatter by 3 um. Three unknowns: the disc's two displacements and its rotation.

    python benchmarks/cycloid_contact.py [--cases 100000] [--scipy 300]

Contestants, alternating, best of three:
    SciPy loop      scipy.optimize.root per case on the three balances, forces of all lobes at once
                    in NumPy (Lambert W), started from the rigid mesh one thread
                    lostmotion.laws.cycloid.contact.loaded
    two threads     the same, the batch cut in two
"""

from __future__ import annotations

import argparse
import math
import time

import numpy as np
from scipy.optimize import root
from scipy.special import lambertw

from lostmotion.laws.contact import equivalent_modulus, johnson_scale
from lostmotion.laws.cycloid.contact import Flanks, Supports, load_sharing
from lostmotion.laws.cycloid.geometry import contact_radius, normals, pin_angles
from lostmotion.laws.cycloid.stage import Stage

STAGE = Stage(0.0775, 0.004, 0.0015, 40)
FLANKS = Flanks(0.015, equivalent_modulus(210e9, 0.3, 210e9, 0.3))
SUPPORTS = Supports(3e8, math.inf, 0.05)
TORQUES = np.concatenate([-np.geomspace(10, 800, 5), np.geomspace(10, 800, 5)])
CRANKS = np.linspace(0, 2 * math.pi, 100, endpoint=False)


def johnson_force(approach: np.ndarray, radius: np.ndarray) -> np.ndarray:
    """Return the forces (N) of Johnson's law, delta = F/(pi E* b) ln(B/F), solved for F by
    Lambert's W.
    """
    delta = np.maximum(approach, 0.0) * math.pi * FLANKS.modulus * FLANKS.width
    share = delta / johnson_scale(FLANKS.width, radius, FLANKS.modulus)
    return -delta / np.real(lambertw(-np.where(share > 0, share, 0.1), -1))


def scipy_loop(gaps: np.ndarray, cases: np.ndarray) -> np.ndarray:
    """Rotation of cases (case, 3), each (torque, crank, draw)."""
    theta = pin_angles(STAGE, CRANKS)
    normal, radius = normals(STAGE, theta), contact_radius(STAGE, theta)
    pitch = STAGE.planet_pitch_radius
    out = np.empty(len(cases))
    for row, (i, j, k) in enumerate(cases):
        torque, n, req, gap = TORQUES[i], normal[j], radius[j], gaps[k]
        unit, thrust = abs(torque) / pitch, -4 * abs(torque) / (math.pi * SUPPORTS.pin_circle)

        def left_over(
            u: np.ndarray, torque=torque, n=n, req=req, gap=gap, unit=unit, thrust=thrust
        ) -> np.ndarray:
            x, y, turn = u * 1e-6
            force = johnson_force(n[:, 0] * x + n[:, 1] * (y + turn) - gap, req)
            across = force @ n[:, 1]
            return (
                np.array(
                    [thrust - 3e8 * x - force @ n[:, 0], -3e8 * y - across, torque / pitch - across]
                )
                / unit
            )

        give = torque / pitch / 3e8
        answer = root(
            left_over,
            np.array([0.0, -give, 1.2 * give + math.copysign(3e-6, torque)]) * 1e6,
            tol=1e-9,
        )
        out[row] = answer.x[2] * 1e-6 / pitch if answer.success else np.nan
    return out


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.partition("\n\n")[0])
    parser.add_argument("--cases", type=int, default=100_000)
    parser.add_argument("--scipy", type=int, default=300)
    options = parser.parse_args()
    rng = np.random.default_rng(1)
    draws = max(options.cases // (len(TORQUES) * len(CRANKS)), 1)
    gaps = 3e-6 * np.abs(rng.standard_normal((draws, STAGE.pins)))
    few = np.stack(
        [rng.integers(0, n, options.scipy) for n in (len(TORQUES), len(CRANKS), draws)], axis=1
    )
    load_sharing(STAGE, FLANKS, TORQUES[:1], CRANKS[:1], gaps[:1], SUPPORTS)  # compile
    cases = len(TORQUES) * len(CRANKS) * draws
    contestants = {
        "SciPy loop": (len(few), lambda: scipy_loop(gaps, few)),
        "one thread": (cases, lambda: load_sharing(STAGE, FLANKS, TORQUES, CRANKS, gaps, SUPPORTS)),
        "two threads": (
            cases,
            lambda: load_sharing(STAGE, FLANKS, TORQUES, CRANKS, gaps, SUPPORTS, threads=2),
        ),
    }
    best, results = dict.fromkeys(contestants, math.inf), {}
    for _ in range(3):
        for name, (count, contestant) in contestants.items():
            start = time.perf_counter()
            results[name] = contestant()
            best[name] = min(best[name], (time.perf_counter() - start) / count)
    ours = results["two threads"]
    print(f"{cases} loaded contacts of {STAGE.pins} lobes ({len(few)} for SciPy), best of three")
    print(f"{'':12} {'us each':>10} {'per second':>12} {'times SciPy':>12}")
    for name, seconds in best.items():
        print(
            f"{name:12} {seconds * 1e6:10.2f} {1 / seconds:12.0f} "
            f"{best['SciPy loop'] / seconds:12.0f}"
        )
    theirs = results["SciPy loop"]
    same = ours.rotation[tuple(few.T)]
    found = np.isfinite(theirs)
    print(
        f"SciPy found {found.sum()} of {len(few)}; where it did, the rotations differ by at "
        f"most {np.max(np.abs(theirs / same - 1)[found]):.1e}"
    )
    print(
        f"lostmotion converged on {ours.converged.mean():.2%}, largest residual "
        f"{ours.residual.max():.1e} of the torque"
    )


if __name__ == "__main__":
    main()
