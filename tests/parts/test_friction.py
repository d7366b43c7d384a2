"""Friction that holds a play open: how it is stated, how much it scatters from drive to drive, and
what is assumed of it.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import pytest
from pydantic import ValidationError

import lostmotion
from lostmotion import Arm
from lostmotion.error_model.provenance import states
from lostmotion.errors import InputError
from lostmotion.io.arm_writer import reads_back, sized_text
from lostmotion.io.field_schema import inside, models, tag
from lostmotion.parts.error_source import Friction
from lostmotion.parts.joint import PrismaticJoint, RevoluteJoint
from lostmotion.parts.term import Holding, Motion
from lostmotion.reporting.layout import row_at
from lostmotion.units import Toleranced
from tests.parts.conditions import SLIDE_Z, TURN_Z
from tests.parts.random_arms import BEARINGS
from tests.parts.test_cycloidal import DRAWING

if TYPE_CHECKING:
    from pathlib import Path

PLAY = {"backlash": 3e-4}
# Every kind of part that has a play, by the key of its friction: a joint's field, and what states
# the play.
PARTS: dict[str, tuple[str, dict[str, Any]]] = {
    "catalogue": ("gearbox", PLAY),
    "planetary": ("gearbox", {"sun_teeth": 20, "ring_teeth": 70, **PLAY}),
    "wolfrom": (
        "gearbox",
        {
            "sun_teeth": 18,
            "planet_teeth": 36,
            "fixed_ring_teeth": 90,
            "output_planet_teeth": 33,
            "output_ring_teeth": 87,
            **PLAY,
        },
    ),
    "strain wave": ("gearbox", {"flexspline_teeth": 200, "circular_spline_teeth": 202, **PLAY}),
    "worm": ("gearbox", {"wheel_teeth": 60, **PLAY}),
    "belt": (
        "gearbox",
        {"ratio": 4.0, "belt_stiffness": 4.5e5, "strand": 0.2, "pulley_radius": 0.04, **PLAY},
    ),
    "cycloidal": ("gearbox", {**DRAWING, "relief": {"roller": "4 µm"}}),
    "rolling": ("bearing", {"clearance": 3e-5, "axial_play": 2e-5, "span": 0.06}),
    **{str(drawing["kind"]): ("bearing", {**drawing, "clearance": 2e-5}) for drawing in BEARINGS},
}
KEYS = {"gearbox": "friction_torque", "bearing": "closing_force"}
# What a file states, the same from Python, and the friction that both mean. "U" stands for the
# unit.
STATED: dict[str, tuple[object, Friction]] = {
    "2 U": (2.0, Friction(Toleranced(2.0, 1.0), scatter_assumed=True)),
    "2 U ± 30 %": (Toleranced(2.0, 0.6), Friction(Toleranced(2.0, 0.6))),
    "2 U ± 0.5 U": (Toleranced(2.0, 0.5), Friction(Toleranced(2.0, 0.5))),
    "2 U ± 100 % (uniform)": (
        Toleranced(2.0, 2.0, "uniform"),
        Friction(Toleranced(2.0, 2.0, "uniform")),
    ),
    "2 U ± 0 %": (Toleranced(2.0), Friction(Toleranced(2.0))),
    "2 U ± 0 U": (Toleranced(2.0), Friction(Toleranced(2.0))),
    "0 U": (0.0, Friction(Toleranced(0.0))),
}


def joint_with(kind: str, stated: object = None, **also: object) -> RevoluteJoint:
    """Return a turning joint with a part of this kind, which states a friction or none."""
    slot, fields = PARTS[kind]
    friction = {} if stated is None else {KEYS[slot]: stated}
    return RevoluteJoint(
        name="A",
        limits=(-1, 1),
        axis="y",
        link={"length": 0.5},
        **{slot: {"kind": kind, **fields, **friction, **also}},
    )


def frictions_of(joint: RevoluteJoint | PrismaticJoint, load: float = 0.0) -> list[Friction]:
    """Return the frictions of a joint's parts, which holds this load in every direction."""
    found = [
        source.play_friction(lambda: Holding(load, load, load)) for source in joint.sources.values()
    ]
    return [friction for friction in found if friction is not None]


def test_every_kind_with_a_friction_is_among_these():
    """No kind of gearbox or bearing has a friction that the tests of this file miss."""
    having = {
        tag(model)
        for slot, key in KEYS.items()
        for model in models(inside([RevoluteJoint], slot))
        if key in model.model_fields
    }
    assert having == set(PARTS)


@pytest.mark.parametrize("kind", PARTS)
def test_a_friction_states_its_scatter_or_that_it_has_none(kind: str):
    """Text and numbers mean the same; without ± the scatter is assumed, and a scatter of zero is
    stated by ± 0 %.
    """
    slot, _ = PARTS[kind]
    for text, (number, friction) in STATED.items():
        for stated in (text.replace("U", "N m" if slot == "gearbox" else "N"), number):
            part = getattr(joint_with(kind, stated), slot)
            found = getattr(part, KEYS[slot])
            assert found == friction
            # the search for parts validates the fields of a part again
            assert (
                getattr(
                    type(part).model_validate(
                        {name: getattr(part, name) for name in part.model_fields_set}
                    ),
                    KEYS[slot],
                )
                == friction
            )


@pytest.mark.parametrize("kind", PARTS)
def test_the_friction_of_a_part_is_that_of_its_seats(kind: str):
    """Every play of a part has the friction that is stated, with its scatter; the friction can be
    compared and hashed.
    """
    stated = Toleranced(2.0, 0.7, "uniform")
    joint = joint_with(kind, stated)
    assert set(frictions_of(joint)) == {Friction(stated)}
    forms = [
        term.form for source in joint.sources.values() for term in source.terms(Motion(TURN_Z))
    ]
    plays = [form.seat for form in forms if hasattr(form, "seat")] + [
        seat for form in forms if hasattr(form, "shaft") for seat in form.shaft.seats
    ]
    assert plays
    assert {seat.friction for seat in plays} == {stated}


@pytest.mark.parametrize("kind", PARTS)
def test_an_assumed_friction_scatters_by_half(kind: str):
    """What is assumed has the default scatter, in proportion to its size, and says that it is
    assumed.
    """
    found = frictions_of(joint_with(kind), 1000.0)
    assert found
    for friction in found:
        assert friction.load == Toleranced(friction.load.nominal, 0.5 * friction.load.nominal)
        assert friction.load.nominal > 0
        assert friction.scatter_assumed
        assert friction.reason


def test_the_friction_of_a_sliding_drive_is_a_force():
    """A screw drive and the encoder behind it state their friction in newtons, and their play has
    its scatter.
    """
    for encoder in (None, {"side": "output", "resolution": 1e-6}):
        fields = {"backlash": 2e-5, "friction_torque": "20 N ± 25 %"}
        joint = PrismaticJoint(name="A", limits=(0, 1), gearbox=fields, encoder=encoder)
        assert frictions_of(joint) == [Friction(Toleranced(20.0, 5.0))]
        terms = joint.sources["gearbox"].terms(Motion(SLIDE_Z))
        assert {term.form.seat.friction for term in terms if hasattr(term.form, "seat")} == {
            Toleranced(20.0, 5.0)
        }


@pytest.mark.parametrize(
    ("stated", "why"),
    [
        ("-1 U", "out of range"),
        (-1.0, "out of range"),
        ("2 U ± 101 %", "the tolerance reaches out of range"),
        ("2 U ± 2.1 U", "the tolerance reaches out of range"),
        (Toleranced(2.0, 2.1), "the tolerance reaches out of range"),
        ("0 U ± 0.1 U", "the tolerance reaches out of range"),
        ("2 U ± -3 %", "a tolerance after ± cannot be negative"),
        ("2 U ± 30 kg", "'kg' is not a unit of"),
        ("2 mm ± 30 %", "'mm' is not a unit of"),
        ("2 ± 30 %", "without a unit of"),
        (
            "2 U ± 30 % (normal without limits)",
            "a distribution other than normal or uniform, and here limits must hold",
        ),
        (
            Toleranced(2.0, 1.0, ((-1.0, 0.0), (1.0, 1.0))),
            "a distribution other than normal or uniform, and here limits must hold",
        ),
        ("2 U ± 30 % of 2 U", "not a number with a unit"),
        (float("nan"), "not a finite number"),
        (True, "not a quantity"),
    ],
)
@pytest.mark.parametrize("kind", PARTS)
def test_an_impossible_friction_is_refused(kind: str, stated: object, why: str):
    """A friction is zero or more in every drive, has the unit of its load, and limits."""
    slot, _ = PARTS[kind]
    unit, example = ("N m", "1 N m ± 30 %") if slot == "gearbox" else ("N", "5 N ± 30 %")
    with pytest.raises(ValidationError) as refused:
        joint_with(kind, stated.replace("U", unit) if isinstance(stated, str) else stated)
    (error,) = refused.value.errors()
    assert error["loc"][-1] == KEYS[slot]
    assert error["ctx"]["why"].startswith(why)
    assert error["ctx"]["expected"].endswith("zero or more, with or without ± tolerance")
    assert error["ctx"]["example"] == f'"{example}"'


def test_a_mistake_in_a_file_is_shown_with_its_key(tmp_path: Path):
    """Both frictions of a file are refused at once, each under its key."""
    path = tmp_path / "arm.toml"
    path.write_text(
        'name = "x"\n[[joints]]\nname = "A"\ntype = "revolute"\nlimits = ["-1 rad", "1 rad"]\n'
        'link = { length = "1 m" }\n'
        'gearbox = { backlash = "1 arcmin", friction_torque = "0.5 N m ± 120 %" }\n'
        'bearing = { kind = "rolling", span = "60 mm", clearance = "20 µm", closing_force = '
        '"5 N m" }\n'
    )
    with pytest.raises(InputError) as refused:
        lostmotion.read(path)
    torque, force = sorted(refused.value.problems, key=lambda each: each.key, reverse=True)
    assert str(torque) == (
        f"{path}:7: joints.A.gearbox.friction_torque\n  found     '0.5 N m ± 120 %' (the "
        "tolerance reaches out of range)\n"
        "  expected  torque (N m), zero or more, with or without ± tolerance\n  example   "
        'friction_torque = "1 N m ± 30 %"'
    )
    assert force.key == "joints.A.bearing.closing_force"
    assert force.expected == "force (N, kN), zero or more, with or without ± tolerance"


def test_an_assumed_scatter_is_a_remark_and_a_default():
    """It is listed beside the results and among the assumed values, where ± is not stated; a stated
    scatter is not listed.
    """

    def arm(**friction: object) -> Arm:
        joints = [
            joint_with("catalogue", **{"rated_torque": 80.0, **friction}).model_copy(
                update={"name": name}
            )
            for name in ("A", "B")
        ]
        return Arm(name="two", joints=joints)

    def assumed(**friction: object) -> set[tuple[str, str]]:
        return {(each.key, each.reason) for each in states(arm(**friction)).assumed}

    end = "; a smaller load does not close the play"
    assert arm().remarks == (
        (
            "friction of the gearbox of A, B: not stated, assumed 1 % of the rated torque, ±50 % "
            f"(0.8 N m){end}"
        ),
    )
    assert assumed() == {("friction_torque", "default, 1 % of the rated torque, ±50 %")}
    assert arm(stated="1 N m").remarks == (
        "scatter of the friction of the gearbox of A, B: not stated, assumed ±50 %",
    )
    assert assumed(stated="1 N m") == {("friction_torque", "default scatter, ±50 %")}
    for stated in ("1 N m ± 20 %", "1 N m ± 0 %", "0 N m"):
        assert arm(stated=stated).remarks == ()
        assert assumed(stated=stated) == set()
    # A friction that the user assumes is the user's assumption; its scatter remains a remark.
    assert assumed(stated="1 N m", assumed=("friction_torque",)) == {("friction_torque", "assumed")}
    assert arm(stated="1 N m", assumed=("friction_torque",)).remarks == arm(stated="1 N m").remarks


def test_a_part_without_play_has_no_friction_to_assume():
    """Nothing is listed for a gearbox without play, whatever friction it states."""
    arm = Arm(name="x", joints=[joint_with("catalogue", "1 N m", rated_torque=80.0, backlash=0.0)])
    assert arm.remarks == ()
    assert states(arm).assumed == ()


def test_an_assumed_scatter_alone_leaves_the_headline_as_it_is():
    """The headline counts assumed values; a stated friction whose scatter is assumed is none, and
    the table lists it.
    """
    assumed, scattered, stated = (
        lostmotion.study(
            Arm(name="x", joints=[joint_with("catalogue", friction, rated_torque=80.0)]), 16, 4, 2
        ).sheet
        for friction in (None, "0.8 N m", "0.8 N m ± 50 %")
    )
    assert "This rests on 1 assumed value" in assumed.verdict
    assert scattered.verdict == stated.verdict
    assert "assumed" not in stated.verdict
    tables = (
        next(section for section in sheet.sections if section.key == "inputs")
        for sheet in (scattered, stated)
    )
    states_of = [{row.cells[1].words for row in table.rows} for table in tables]
    assert states_of[0] - states_of[1] == {"default scatter, ±50 %"}
    assert states_of[1] == {"stated", "ideal"}


def test_the_sheet_of_a_gearbox_shows_the_friction_with_its_limits(tmp_path: Path):
    """Stated limits as such, assumed ones with what is assumed."""

    def row(stated: str) -> tuple[float, float, str, str]:
        path = tmp_path / "gearbox.toml"
        lines = [
            "[gearbox]",
            'rated_torque = "80 N m"',
            'stiffness = "20 N m/arcmin"',
            'backlash = "1 arcmin"',
            "ratio = 100",
            stated,
        ]
        path.write_text("\n".join(lines))
        sheet = lostmotion.gear(path).sheet
        found = row_at(sheet.sections, "stated", "friction_without_load_as_torque")
        assert row_at(sheet.sections, "loop", "play").note.endswith(
            f"overcome friction{found.note and f' ({found.note})'}"
        )
        figure = found.cells[0]
        return figure.low, figure.high, figure.ends if figure.interval else "", found.note

    assert row("") == (
        0.4,
        pytest.approx(1.2),
        "assumed limits",
        "not stated, assumed 1 % of the rated torque, ±50 %",
    )
    assert row('friction_torque = "2 N m"') == (
        1.0,
        3.0,
        "assumed limits",
        "scatter not stated, assumed ±50 %",
    )
    assert row('friction_torque = "2 N m ± 30 %"') == (1.4, 2.6, "stated limits", "")
    assert row('friction_torque = "2 N m ± 0 %"')[2:] == ("", "")


def test_a_sized_arm_keeps_its_frictions(tmp_path: Path):
    """The file of the sized arm states every friction as the user's own does: with ±, without, and
    with a scatter of zero.
    """
    joint = """
[[joints]]
name = "{name}"
type = "revolute"
axis = "y"
limits = ["-1 rad", "1 rad"]
gearbox = {{ ratio = 100, backlash = "1 arcmin", friction_torque = "{torque}" }}
bearing = {{ kind = "rolling", span = "60 mm", clearance = "20 µm", closing_force = "{force}" }}
link = {{ length = "300 mm", section = {{ kind = "tube", outer = "80 mm", wall = "3 mm" }}, material = "aluminium" }}
"""
    stated = {
        "A": ("1 N m", "5 N ± 30 %"),
        "B": ("1 N m ± 0 %", "5 N"),
        "C": ("1 N m ± 0.2 N m (uniform)", "0 N"),
    }
    path, out = tmp_path / "arm.toml", tmp_path / "sized.toml"
    path.write_text(
        'name = "x"\npayload = { mass = "4 kg" }\n'
        + "".join(joint.format(name=n, torque=t, force=f) for n, (t, f) in stated.items())
    )
    size = lostmotion.size(path, poses=8)
    out.write_text(sized_text(path, None, size), encoding="utf-8")
    assert not reads_back(path, out, size)
    before, after = (
        [
            (each.gearbox.friction_torque, each.bearing.closing_force)
            for each in lostmotion.read(file).joints
        ]
        for file in (path, out)
    )
    assert after == before
    assert len(set(before)) == len(stated)
