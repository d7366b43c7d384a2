"""The example arms beside machines of their class: each figure is pinned, and stands where makers and publications put such machines."""

from pathlib import Path

import pytest

import lostmotion

EXAMPLES = Path(__file__).parents[2] / "examples"
METRES = {"m": 1.0, "mm": 1e-3, "µm": 1e-6}
# File, mean RP and AP (m) of a small study at seed 1, and the range of RP (m) that makers print for machines of this class.
# AP has no published range: makers of such arms do not print it.
MACHINES = (
    # Makers print ±0.02 to ±0.04 mm for the first two joints of a SCARA of 600 mm.
    ("scara.toml", 30.6e-6, 0.129e-3, (20e-6, 40e-6)),
)


@pytest.mark.parametrize(("file", "repeatability", "accuracy", "published"), MACHINES, ids=lambda value: value if isinstance(value, str) else "")
def test_an_example_is_as_repeatable_as_machines_of_its_class(file, repeatability, accuracy, published):
    """RP and AP are the pinned figures, and RP lies within what makers print for the class."""
    figures = lostmotion.study(lostmotion.read(EXAMPLES / file), 64, robots=100, visits=10).result()["figures"]["iso9283"]
    found = {key: figures[key]["value"] * METRES[figures[key]["unit"]] for key in ("RP_mean", "AP_mean")}
    assert found["RP_mean"] == pytest.approx(repeatability, rel=0.01)
    assert found["AP_mean"] == pytest.approx(accuracy, rel=0.01)
    assert published[0] <= found["RP_mean"] <= published[1]
