"""result.json: a key has one unit, an SI unit, whatever arm or part is asked about."""

import json
import re
from collections import defaultdict
from pathlib import Path

import pytest

import lostmotion
from lostmotion.parts.gearbox.cycloidal import model
from lostmotion.printed import UNITS
from lostmotion.propagation.iso9283 import largest_cube
from tests.arms import JOINT, arm_of

EXAMPLES = Path(__file__).parents[2] / "examples"
ARMS = sorted(
    path
    for path in (*EXAMPLES.glob("*.toml"), *EXAMPLES.glob("*.urdf"))
    # the other half of ur5e.urdf; the keys of z-arm.toml and arm-from-drawings.toml
    if path.name not in {"ur5e.toml", "z-arm-drawn.toml"}
)
SI = {si for si, _ in UNITS.values()}


# Every key of an ISO sheet has its unit from these: joints that turn and slide, closed chains, heat,
# drawn gearboxes, arms of millimetres and of metres.
ISO = (
    "arm-from-drawings.toml",
    "arm-in-the-sun.toml",
    "gantry.toml",
    "palletiser.toml",
    "six-axis.toml",
    "tracked-base.toml",
)


# Joints that slide in one example and turn in another: their loads are forces here, torques there.
OF_BOTH_KINDS = ("lift",)


def units_in(figures, at=()):
    """Yield the path of every figure with its unit."""
    for key, found in figures.items():
        if "value" in found and "samples" in found:
            if found["unit"] is not None:
                yield (*at, key), found["unit"]
        else:
            yield from units_in(found, (*at, key))


def check(results):
    """Check that each key has one unit over all results of a question, and an SI unit."""
    units = defaultdict(set)
    for result in results:
        for path, unit in units_in(result.result()["figures"]):
            if not any(each.split("_")[0] in OF_BOTH_KINDS for each in path):
                units[path].add(unit)
    assert len(units) > 10
    assert {path: found for path, found in units.items() if len(found) > 1} == {}
    assert {path: found for path, found in units.items() if not found <= SI} == {}


def test_keys_of_a_study_have_one_unit_whatever_the_size_of_the_arm():
    """A gantry that errs by micrometres, and an arm whose joints are stated in arcseconds beside the
    same one with degrees, which errs by centimetres.
    """
    fine, coarse = (
        arm_of(**json.loads(re.sub("(?<!/)arcmin", unit, json.dumps(JOINT))))
        for unit in ("arcsec", "deg")
    )
    found = [lostmotion.study(each, 16, 20, 3) for each in (EXAMPLES / "gantry.toml", fine, coarse)]
    assert 10 * found[1].p95.value < found[2].p95.value
    check(found)


@pytest.fixture(scope="module")
def arms():
    """Return every example as an arm, read once for all questions."""
    return {path.name: lostmotion.read(path) for path in ARMS}


@pytest.fixture
def any_cube(monkeypatch):
    """Enlarge one candidate of the test cube in place of eight, and draw few gearboxes: units are
    those of any cube and of any number.
    """
    monkeypatch.setattr(largest_cube, "_ENLARGED", 1)
    monkeypatch.setattr(largest_cube, "_CONFIGURATIONS", 1)
    monkeypatch.setattr(model, "GEARBOXES", 8)
    model._behaviour.cache_clear()
    yield
    model._behaviour.cache_clear()


@pytest.mark.slow
@pytest.mark.few_counts
@pytest.mark.usefixtures("any_cube")
@pytest.mark.parametrize(
    ("ask", "names"),
    [
        (lambda arm: lostmotion.study(arm, 8, 4, 2, target="1 mm"), None),
        (lambda arm: lostmotion.statics(arm, poses=4), None),
        (lambda arm: lostmotion.iso9283(arm, robots=2, visits=2), ISO),
    ],
    ids=["study", "statics", "iso9283"],
)
def test_keys_have_one_unit_over_all_arms(ask, names, arms):
    """Every example that answers the question, or those that have all keys of it."""
    answer(ask, [arms[name] for name in names or arms])


@pytest.mark.slow
@pytest.mark.few_counts
def test_keys_of_a_check_have_one_unit_over_all_arms():
    """Every file of the examples."""
    answer(lostmotion.check, ARMS)


def answer(ask, arms):
    """Check the keys of the arms that answer a question."""
    found = []
    for arm in arms:
        try:
            found.append(ask(arm))
        except lostmotion.LostmotionError:  # no cube, nothing elastic ...
            continue
    assert len(found) > 5
    check(found)


@pytest.mark.slow
def test_keys_of_a_gearbox_have_one_unit():
    """Every part file of the examples."""
    check(lostmotion.gear(path) for path in sorted((EXAMPLES / "gearbox").glob("*.toml")))
