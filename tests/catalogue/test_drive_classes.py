"""Classes of drive: laws by the load of the drive, beside the rows of the catalogue and physics
that they do not use.
"""

from __future__ import annotations

import numpy as np
import pytest

from lostmotion.catalogue.drive_classes import class_of, drive_classes, neighbours, scaled
from lostmotion.catalogue.gearbox_row import mark_of
from lostmotion.catalogue.gearboxes import gearboxes
from lostmotion.error_model.provenance import states
from lostmotion.io.native import arm_of

# A row of docs/validation.md each: quantity, compared with, agreement, other files.
VALIDATES = (
    (
        "stiffness by class of drive, over rated torque",
        "every RV and CSG row of the catalogue",
        "25 and 30 %, the scatter of the classes; exponent within 0.05",
        "catalogue/drive_classes.toml",
    ),
    (
        "moment stiffness of main bearings by class",
        "every RV row of the catalogue that states it",
        "35 %",
        "catalogue/drive_classes.toml",
    ),
)

CLASSES = drive_classes()
LIMITS = {"revolute": ["-90 deg", "90 deg"], "prismatic": ["0 mm", "500 mm"]}
KEYS = {"revolute": ("torque", "N m"), "prismatic": ("force", "N")}


def joint_of(name: str, kind: str, load: float):
    """Return the joint of an arm of one joint whose drive is of this class and load."""
    key, unit = KEYS[kind]
    joint = {
        "name": "A",
        "type": kind,
        "limits": LIMITS[kind],
        "link": {"length": "300 mm"},
        "drive": {key: f"{load!r} {unit}"},
    }
    return arm_of("arm.toml", {"name": "x", "presets": {"drives": name}, "joints": [joint]})


def stiffnesses(maker: str) -> list[tuple[float, float]]:
    """Return rated torque (N m, of ratio 100 where it depends on the ratio) and middle stiffness (N
    m/rad) of a maker's series.
    """
    found = []
    for row in gearboxes():
        part = row.figures.part
        if row.maker == "Nabtesco" and maker == row.maker:
            found.append((part.rated_torque, part.zones[0]))
        elif row.maker == maker and row.models[0].startswith("CSG") and row.ratio_above == 50:
            by_ratio = row.figures.torques_by_ratio
            found.append(
                (by_ratio["100"][0] if "100" in by_ratio else part.rated_torque, part.zones[1])
            )
    return found


@pytest.mark.parametrize("kind", KEYS)
@pytest.mark.parametrize("name", CLASSES)
def test_a_class_describes_every_kind_of_error_of_a_real_drive(name, kind):
    """Play or its absence, stiffness, friction, encoder, bearing, mounting and link: nothing is
    taken as perfect, and all of it is assumed.
    """
    (found,) = states(joint_of(name, kind, CLASSES[name].reference(kind))).joints
    expected = {
        "backlash",
        "stiffness",
        "hysteresis",
        "transmission error",
        "bearing",
        "encoder",
        "axis mounting",
        "link bending",
        "link length",
    }
    assert {each for each in expected if found.states[each] != "assumed"} == set()
    assert "stated" not in found.states.values()
    assert joint_of(name, kind, CLASSES[name].reference(kind)).joints[0].servo.dead_band > 0


@pytest.mark.parametrize("kind", KEYS)
@pytest.mark.parametrize("name", CLASSES)
def test_every_part_of_a_class_has_a_source_with_its_mark(name, kind):
    """No number without a source, or a stated estimate."""
    laws = CLASSES[name].laws[kind]
    assert mark_of(laws["source"])
    parts = [
        part
        for part, values in laws.items()
        if isinstance(values, dict) and values.keys() != {"at", "power"}
    ]
    assert len(parts) >= 6
    assert all(mark_of(CLASSES[name].source(kind, part)) for part in parts)


@pytest.mark.parametrize("kind", KEYS)
@pytest.mark.parametrize("name", CLASSES)
def test_a_larger_drive_of_a_class_is_stiffer_and_no_worse(name, kind):
    """Stiffness rises with the load over three decades, play and dead band do not, and nothing
    jumps: a thousandth of load changes little.
    """
    loads = CLASSES[name].reference(kind) * np.geomspace(0.03, 30, 13)
    joints = [joint_of(name, kind, float(load)).joints[0] for load in loads]
    stiffness = [each.gearbox.zones[0] for each in joints]
    assert stiffness == sorted(stiffness)
    assert stiffness[-1] > 100 * stiffness[0]
    for figure in (lambda each: each.gearbox.play.nominal, lambda each: each.servo.dead_band):
        values = [figure(each) for each in joints]
        assert values == sorted(values, reverse=True)
    near = joint_of(name, kind, float(loads[6]) * 1.001).joints[0]
    assert near.gearbox.zones[0] == pytest.approx(joints[6].gearbox.zones[0], rel=2.5e-3)


@pytest.mark.parametrize(
    ("maker", "name"), [("Nabtesco", "large RV"), ("Harmonic Drive", "small strain wave")]
)
def test_the_law_of_stiffness_holds_for_the_reducers_of_the_catalogue(maker, name):
    """Stiffness over rated torque: every row of the maker lies within the scatter of the law, and
    the power fitted to the rows agrees with it.
    """
    rows = stiffnesses(maker)
    assert len(rows) >= 8
    for torque, measured in rows:
        gearbox = of_rated(name, torque)
        assert gearbox.rated_torque == pytest.approx(torque, rel=5e-3)
        assert measured == pytest.approx(gearbox.zones[0], rel=gearbox.stiffness_scatter)
    torques, measured = np.array(rows).T
    law = np.array([of_rated(name, float(torque)).zones[0] for torque in torques])
    fitted, stated = (
        np.polyfit(np.log(torques), np.log(values), 1)[0] for values in (measured, law)
    )
    assert fitted == pytest.approx(stated, abs=0.05)


def of_rated(name: str, torque: float):
    """Return the gearbox of this class with this rated torque, N m: that of a drive that gives 1.5
    times as much.
    """
    return joint_of(name, "revolute", 1.5 * torque).joints[0].gearbox


def test_the_main_bearings_of_rv_reducers_follow_the_law_of_their_class():
    """Moment rigidity by torque, of rows that state both, within a third of the law over a factor
    of 70 in torque.
    """
    rows = [
        (row.figures.part.rated_torque, row.moment_rigidity)
        for row in gearboxes()
        if row.maker == "Nabtesco" and row.moment_rigidity is not None
    ]
    assert len(rows) >= 8
    for torque, rigidity in rows:
        bearing = joint_of("large RV", "revolute", 1.5 * torque).joints[0].bearing
        assert bearing.moment_stiffness == pytest.approx(rigidity, rel=0.35)


def test_planetary_rows_bound_the_play_and_bracket_the_stiffness_of_stepper_drives():
    """The class is that of plain planetary units: its play is no more than a maker's limit, its
    stiffness within a factor of 2 of theirs.
    """
    rows = [row for row in gearboxes() if row.models[0] in ("PLE040", "PLE060", "PLE080")]
    assert len(rows) == 3
    for row in rows:
        part, of_class = (
            row.figures.part,
            joint_of("stepper", "revolute", row.figures.part.rated_torque).joints[0].gearbox,
        )
        assert of_class.play.nominal <= part.play.nominal
        assert of_class.play.nominal >= part.play.nominal / 3
        assert 0.5 < of_class.zones[0] / part.zones[0] < 2


def test_classes_are_in_order_of_size_and_cover_every_load():
    """Every load has one class, larger loads have the same or a later one, and each class has its
    neighbours.
    """
    orders = [class_of("revolute", load).order for load in np.geomspace(1e-3, 1e6, 200)]
    assert orders == sorted(orders)
    assert set(orders) == set(range(len(CLASSES)))
    names = list(CLASSES)
    assert [each.name for each in neighbours(names[0])] == names[:2]
    assert [each.name for each in neighbours(names[2])] == names[1:4]
    assert [each.name for each in neighbours(names[-1])] == names[-2:]


def test_a_tolerance_scales_with_its_value_and_a_share_does_not():
    """The quantity as a file would state it, without powers of ten."""
    assert scaled("0.9 deg ± 0.4 deg", 0.5) == "0.45 deg ± 0.2 deg"
    assert scaled("0.15 N m ± 70 %", 2) == "0.3 N m ± 70 %"
    assert scaled("58e3 N m/rad", 1e-9) == "0.000058 N m/rad"
