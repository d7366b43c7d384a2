"""Arms that the study's tests share."""

import os

import pytest

# Before NumPy is loaded: the suite runs on all processors already, and threads of dense algebra
# inside each worker only wait for each other.
os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")

from lostmotion import Arm

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


@pytest.fixture(scope="session")
def arm() -> Arm:
    """Return an arm with every kind of error."""
    return arm_of()
