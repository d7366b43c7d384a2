"""Arms and a small study that the tests share."""

from __future__ import annotations

import functools

from lostmotion import Arm, Study, study

JOINT = {
    "type": "revolute",
    "axis": "y",
    "limits": (-1.2, 1.2),
    "gearbox": {
        "backlash": "0.5 arcmin ± 0.2 arcmin",
        "stiffness": "120 N m/arcmin",
        "stiffness_scatter": "10 %",
        "transmission_error": "0.6 arcmin",
        "hysteresis": "0.1 arcmin",
        "ratio": 121,
    },
    "bearing": {"kind": "rolling", "clearance": "20 µm ± 10 µm", "span": "80 mm"},
    "encoder": {
        "resolution": "1 arcmin",
        "noise": "0.5 arcmin",
        "eccentricity": "2 arcmin",
        "zero": "0.2 arcmin",
    },
    "mounting": {"tilt": "0.5 arcmin", "offset": "20 µm"},
    "mass": "1 kg",
    "link": {
        "length": "400 mm ± 50 µm",
        "section": {"kind": "tube", "outer": "80 mm", "wall": "4 mm"},
        "material": {"young": "70 GPa", "poisson": 0.33, "density": "2700 kg/m^3"},
    },
}


def arm_of(count: int = 3, **changes: object) -> Arm:
    """Return an arm whose first joint turns about the vertical and the others about the
    horizontal.
    """
    joints = [{**JOINT, **changes, "name": "O", "axis": "z"}] + [
        {**JOINT, **changes, "name": name} for name in "ABCDE"[: count - 1]
    ]
    return Arm.model_validate({"name": "test arm", "joints": joints, "payload": {"mass": "3 kg"}})


# Joints without stiffness scatter, noise and mass of their own.
LINK = {"length": "400 mm ± 50 µm", "section": {"kind": "tube", "outer": "60 mm", "wall": "3 mm"}}
LINK["material"] = {"young": "70 GPa", "poisson": 0.33, "density": "2700 kg/m^3"}
PLAIN = {
    "type": "revolute",
    "axis": "y",
    "limits": (-1, 1),
    "gearbox": {
        "backlash": "0.5 arcmin ± 0.2 arcmin",
        "stiffness": "120 N m/arcmin",
        "transmission_error": "1 arcmin",
        "ratio": 121,
    },
    "bearing": {"kind": "rolling", "clearance": "40 µm ± 20 µm", "span": "50 mm"},
    "encoder": {"resolution": "1 arcmin"},
    "mounting": {"tilt": "0.5 arcmin", "offset": "20 µm"},
    "link": LINK,
}
TURNING = tuple({**PLAIN, "name": name, "axis": "z" if name == "O" else "y"} for name in "OABC")
STIFF = {
    "type": "revolute",
    "axis": "z",
    "limits": (-1, 1),
    "name": "O",
    "link": {"length": "400 mm"},
}


@functools.cache
def small_study(
    poses: int = 64, robots: int = 32, visits: int = 3, threads: int = 1, name: str = "test arm"
) -> Study:
    """Return the study of an arm of four joints at few poses; computed once in a process."""
    arm = Arm.model_validate({"name": name, "joints": TURNING, "payload": {"mass": "3 kg"}})
    return study(arm, poses, robots, visits, threads=threads)
