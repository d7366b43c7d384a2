"""A calibration as the text of the file that `calibration_file` reads."""

from __future__ import annotations

from dataclasses import asdict
from typing import TYPE_CHECKING

import numpy as np

from lostmotion.laws.distributions import Cosine, Sine

if TYPE_CHECKING:
    from lostmotion.calibration.terms import Deviations
    from lostmotion.laws.distributions import Law
    from lostmotion.mechanism.calibration import Calibration
    from lostmotion.spatial import Floats

# A direction below this share of the largest variance is rounding.
_ROUNDING = 1e-13
# Law of the draw of each phase of a harmonic, by the names in the file: those of the laws.
_PHASES: dict[type[Law], str] = {Sine: "sine", Cosine: "cosine"}


def calibration_text(
    calibration: Calibration, sizes: Deviations, *, poses: int, digest: str
) -> str:
    """Return the text of a calibration file.

    sizes   prior deviations of the added errors
    poses   number of measured poses
    digest  hash of the measured data
    """
    covariance = calibration.covariance
    deviations = np.sqrt(np.diag(covariance))
    joint = (covariance != np.diag(np.diag(covariance))).any(axis=1)
    factor: list[str] = []
    if joint.any():
        rows = _factor(covariance[np.ix_(joint, joint)])
        factor = [f"  [{', '.join(f'{each:.9g}' for each in row)}]," for row in rows]
        factor = ["factor = [", *factor, "]", ""]
    names = [name for name, _ in calibration.streams]
    lines = [
        "# Estimates of the errors of one robot, by lostmotion calibrate: every command takes this",
        "# file as --calibration. They are in standard deviations of what the arm file states, or",
        "# of [added]. Estimates with a deviation are independent; the covariance of all others is",
        "# factor times its transpose.",
        "",
        *factor,
        "[data]",
        f"poses = {poses}",
        f'hash = "{digest}"',
        "",
        "[added]  # standard deviations, rad and m, of errors that the arm file does not state",
        *(f"{key} = {value!r}" for key, value in asdict(sizes).items()),
    ]
    for (name, law), mean, deviation, tied in zip(
        calibration.streams, calibration.mean, deviations, joint, strict=True
    ):
        lines += ["", "[[estimates]]", f'draw = "{name}"']
        lines += [f'phase = "{_PHASES[type(law)]}"'] if names.count(name) > 1 else []
        lines.append(f"mean = {float(mean)!r}" + (f"  # ± {deviation:.2g}" if tied else ""))
        lines += [] if tied else [f"deviation = {float(deviation)!r}"]
    return "\n".join(lines) + "\n"


def _factor(covariance: Floats) -> Floats:
    """Return a factor F of the covariance F F', as narrow as its rank."""
    values, vectors = np.linalg.eigh(covariance)
    kept = values > _ROUNDING * values.max(initial=0.0)
    return np.asarray((vectors * np.sqrt(np.maximum(values, 0.0)))[:, kept][:, ::-1])
