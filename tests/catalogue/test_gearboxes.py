"""The catalogue of reducers: every row can be used, states its source, and winds up as its maker
prints.
"""

from __future__ import annotations

import itertools
import math
import re

import numpy as np
import pytest
from pydantic import ValidationError

from lostmotion.catalogue.gearbox_row import GearboxRow
from lostmotion.catalogue.gearboxes import find_gearbox, gearbox_models, gearboxes
from lostmotion.errors import InputError
from lostmotion.parts.joint import RevoluteJoint
from tests.parts.conditions import ARCMIN, condition, terms_at

ROWS = [pytest.param(row, id=f"{row.models[0]}, ratio {row.ratios}") for row in gearboxes()]
STRAIN_WAVE = [row for row in gearboxes() if row.maker == "Harmonic Drive"]
RV = [row for row in gearboxes() if row.maker == "Nabtesco"]
PLANETARY = [row for row in gearboxes() if row.maker.startswith("Beckhoff")]
SERIES = ("TP", "SP", "NP", "PLE")
# Sizes of the component sets of strain wave gears.
LARGE = (14, 17, 20, 25, 32, 40, 50, 58)


def of_row(row: GearboxRow, **stated: object):
    """Return a joint with this row, as from a file."""
    joint = {
        "name": "A",
        "type": "revolute",
        "limits": ["-90 deg", "90 deg"],
        "gearbox": row.with_stated(dict(stated)),
    }
    return RevoluteJoint.model_validate(joint, context={"text": True}).gearbox


@pytest.mark.parametrize("row", ROWS)
def test_every_row_is_a_gearbox_with_its_source(row: GearboxRow):
    """A row is complete, is not an ideal gearbox, and its source has a mark of confidence;
    hysteresis is missing only where it is named.
    """
    part = of_row(row)
    assert part.zones
    assert part.play.nominal >= 0
    assert (part.hysteresis is None) == ("hysteresis" in row.unstated)
    assert (part.hysteresis or 0) + part.play.nominal > 0
    assert re.search(r"\[(R|V|M \d\d)\]$", row.source)
    assert set(row.upper_limits) <= set(row.part)
    assert terms_at(part, condition((1.0,) * 6))


def test_every_ratio_of_a_model_belongs_to_one_row():
    """No reducer is described twice, and its ratio classes do not overlap."""
    for model in gearbox_models():
        rows = [row for row in gearboxes() if model in row.models]
        for ratio in (
            1.0,
            3.0,
            4.0,
            5.0,
            7.0,
            8.0,
            10.0,
            25.0,
            30.0,
            32.0,
            50.0,
            50.5,
            64.0,
            80.0,
            100.0,
            160.0,
        ):
            assert sum(row.applies_to(ratio) for row in rows) <= 1
        assert all(row.applies_to(row.typical_ratio or 100.0) for row in rows)


def test_a_row_of_several_ratios_applies_to_these_only():
    """A single-stage planetary gear unit has the ratios of its table and no other; each leads to
    its row.
    """
    for row in PLANETARY:
        ratios = row.ratio_one_of or (row.ratio,)
        assert len(set(ratios)) == len(ratios)
        assert all(find_gearbox(f"{row.models[0]}-{ratio:g}") == (row, ratio) for ratio in ratios)
        assert not row.applies_to(max(ratios) + 0.5)
        assert not set(map(float, row.inertia_by_ratio)) - set(ratios)
    with pytest.raises(InputError, match="4, 5, 7 or 8, 10"):
        find_gearbox("TP010-MF-6")


def test_planetary_gear_units_grow_with_their_size():
    """From size to size a planetary series carries more, is stiffer and heavier, and its backlash
    limit does not grow.

    Stiffness of geometrically similar gears at a similar stress rises with the torque: the wind-up
    at the rating, T/K, changes by less than 2.5 within a series while the torque grows a
    hundredfold, and lies between one and twelve arcmin. A higher ratio of the same size has a
    smaller sun and is not stiffer. Mass grows with the torque by a power between 0.6 and 1, so that
    torque per mass rises slowly.
    """
    for series in SERIES:
        rows = [
            row
            for row in PLANETARY
            if row.models[0].startswith(series) and not row.models[0].endswith("-MA")
        ]
        sizes = {
            model: [row for row in rows if row.models[0] == model]
            for model in dict.fromkeys(row.models[0] for row in rows)
        }
        first = [of_row(each[0]) for each in sizes.values()]
        torque, stiffness, mass = (
            np.array([getattr(part, name) for part in first], dtype=float)
            for name in ("rated_torque", "stiffness", "mass")
        )
        assert len(first) >= 4
        for figure in (torque, stiffness, mass):
            assert (np.diff(figure) > 0).all()
        assert (np.diff([part.play.nominal for part in first]) <= 0).all()
        wind_up = torque / stiffness / ARCMIN
        assert wind_up.min() > 1
        assert wind_up.max() < 12
        assert wind_up.max() < 2.5 * wind_up.min()
        assert 0.6 < np.polyfit(np.log(torque), np.log(mass), 1)[0] < 1
        for each in sizes.values():
            stages = [row for row in each if max(row.ratio_one_of or (row.ratio,)) <= 10]
            by_ratio = {
                ratio: of_row(row).stiffness
                for row in stages
                for ratio in row.ratio_one_of or (row.ratio,)
            }
            ordered = [by_ratio[ratio] for ratio in sorted(by_ratio)]
            assert all(after <= 1.05 * before for before, after in itertools.pairwise(ordered))


def test_two_stages_of_a_planetary_have_more_backlash():
    """The limit of the backlash of two stages is larger than that of one; a further stage is
    heavier and softer, and its input pinion lighter.
    """
    one, two = (find_gearbox(f"NPS045-MF-{ratio}")[0] for ratio in (5, 25))
    assert of_row(two).play.nominal > of_row(one).play.nominal
    assert max(two.inertia_by_ratio.values()) < min(one.inertia_by_ratio.values())
    two, three = (find_gearbox(f"TP050-MA-{ratio}")[0] for ratio in (55, 66))
    assert of_row(three).stiffness < of_row(two).stiffness
    assert of_row(three).mass > of_row(two).mass
    assert max(three.inertia_by_ratio.values()) < min(two.inertia_by_ratio.values())


@pytest.mark.parametrize(
    "row", [pytest.param(row, id=f"{row.models[0]}, ratio {row.ratios}") for row in PLANETARY]
)
def test_a_planetary_has_its_printed_backlash_and_wind_up(row: GearboxRow):
    """The row's backlash is the limit in the sheet's words, it replaces no lost motion, and torques
    rise from rated to emergency.
    """
    part = of_row(row)
    limit = re.search(r"backlash (?:≤|<) (\d+)'", row.printed)
    assert part.play.nominal / ARCMIN == pytest.approx(float(limit[1]))
    assert part.lost_motion is None
    assert set(row.upper_limits) == {"backlash"}
    assert part.rated_torque < row.figures.acceleration_torque < row.figures.emergency_torque
    assert _wind_up(part, part.rated_torque) == pytest.approx(
        part.rated_torque / part.stiffness, rel=1e-12
    )


def test_a_row_of_two_kinds_of_ratio_is_refused():
    """A ratio, a list of ratios and a lower bound exclude each other."""
    row = {"models": ["X"], "maker": "X", "part": {}, "source": "none"}
    for two in (
        {"ratio": "5", "ratio_one_of": ["4", "5"]},
        {"ratio_one_of": ["4"], "ratio_above": "3"},
    ):
        with pytest.raises(ValidationError, match=" and ratio_"):
            GearboxRow.model_validate(row | two, context={"text": True})


def test_the_sizes_are_those_of_the_makers():
    """RV-42N, eight RV-E sizes; eleven sizes of CSF in two or three ratio classes, eight of which
    are HFUC too; eight of CSG without ratio 30.
    """
    assert [row.models for row in RV] == [["RV-42N"]] + [
        [f"RV-{size}E"] for size in (6, 20, 40, 80, 110, 160, 320, 450)
    ]
    sizes = [(row.models[0], row.ratio) for row in STRAIN_WAVE]
    small = [(f"CSF-{size}", ratio) for size in (5, 8, 11) for ratio in (30, 50, 100)]
    csf = [
        (f"CSF-{size}", ratio)
        for size in LARGE
        for ratio in (30, 50, None)
        if size < 40 or ratio != 30
    ]
    csg = [
        (f"CSG-{size}", ratio)
        for size in LARGE
        for ratio in (50, None)
        if size < 50 or ratio is None
    ]
    assert sizes == [*small, *csf, *csg]
    series = {tuple(name.partition("-")[0] for name in row.models) for row in STRAIN_WAVE}
    assert series == {("CSF",), ("CSF", "HFUC"), ("CSG",)}


def test_a_csg_is_a_csf_that_carries_three_tenths_more():
    """The maker states 30 % more torque at the same stiffness: every torque of every size and
    ratio, to the rounding of the tables.
    """
    for size in LARGE:
        for ratio in (50, 80, 100, 120, 160):
            rows = [
                row
                for name in ("CSF", "CSG")
                for row in STRAIN_WAVE
                if f"{name}-{size}" in row.models and row.applies_to(ratio)
            ]
            if len(rows) < 2:
                continue
            standard, strong = rows
            assert (
                of_row(standard, ratio=str(ratio)).zones == of_row(strong, ratio=str(ratio)).zones
            )
            if standard.torques_by_ratio and str(ratio) in standard.torques_by_ratio:
                np.testing.assert_allclose(
                    strong.torques_at(ratio), 1.3 * np.array(standard.torques_at(ratio)), rtol=0.02
                )
            elif not standard.torques_by_ratio:
                assert of_row(strong).rated_torque == pytest.approx(
                    1.3 * of_row(standard).rated_torque, rel=0.02
                )


@pytest.mark.parametrize(
    "row", [pytest.param(row, id=f"{row.models[0]}, ratio {row.ratios}") for row in STRAIN_WAVE]
)
def test_a_strain_wave_gear_states_what_it_carries(row: GearboxRow):
    """Rated, repeated and momentary peak torque rise in this order; the row's own are the smallest
    of its ratios, and a ratio leads to its own.

    The wind-up at the rated torque lies between 2 and 12 arcmin in every size: gears of similar
    shape and similar stress.
    """
    part = of_row(row)
    assert part.rated_torque < row.figures.acceleration_torque < row.figures.emergency_torque
    assert 2 < _wind_up(part, part.rated_torque) / ARCMIN < 12
    assert part.mass
    for ratio, torques in row.torques_by_ratio.items():
        assert torques[0] < torques[1] < torques[2]
        assert of_row(row, ratio=ratio).rated_torque == torques[0]
        assert of_row(row, ratio=ratio, rated_torque="1 N m").rated_torque == 1.0
    if row.torques_by_ratio:
        smallest = np.min(list(row.torques_by_ratio.values()), axis=0)
        np.testing.assert_array_equal(
            smallest,
            (part.rated_torque, row.figures.acceleration_torque, row.figures.emergency_torque),
        )


def test_a_larger_strain_wave_gear_carries_more():
    """Within a series and a ratio, rated and peak torques and the mass of the component set rise
    with the size.
    """
    for series, ratios in (("CSF", (30, 50, 100)), ("CSG", (50, 100))):
        for ratio in ratios:
            rows = [
                row
                for row in STRAIN_WAVE
                if row.models[0].startswith(series) and row.applies_to(ratio)
            ]
            torques = np.array(
                [
                    (of_row(row, ratio=str(ratio)).rated_torque, row.figures.acceleration_torque)
                    for row in rows
                ]
            )
            assert len(rows) >= 6
            assert (np.diff(torques, axis=0) > 0).all()


def _wind_up(part, torque):
    return next(
        term.screw[0, 2]
        for term in terms_at(part, condition((0, 0, torque, 0, 0, 0)))
        if term.name == "wind-up"
    )


@pytest.mark.parametrize(
    "row", [pytest.param(row, id=f"{row.models[0]}, ratio {row.ratios}") for row in STRAIN_WAVE]
)
def test_strain_wave_gears_stiffen_zone_by_zone(row: GearboxRow):
    """In every size K1 < K2 < K3, the torques between them rise, and the wind-up at 1.5 T2 is the
    makers' sum exactly.
    """
    part = of_row(row)
    (k1, k2, k3), (t1, t2) = part.zones, part.zone_torques
    assert k1 < k2 < k3
    torque = 1.5 * t2
    by_hand = t1 / k1 + (t2 - t1) / k2 + (torque - t2) / k3
    np.testing.assert_allclose(_wind_up(part, torque), by_hand, rtol=1e-14)


def test_a_larger_size_or_ratio_is_stiffer():
    """Within a ratio class every size is stiffer than the one before, and within a size a higher
    ratio is stiffer.
    """
    for ratio in (30, 50, 100):
        zones = np.array(
            [
                of_row(find_gearbox(f"CSF-{size}", ratio)[0]).zones
                for size in (5, 8, 11, *LARGE)[: 8 if ratio == 30 else 11]
            ]
        )
        assert (np.diff(zones, axis=0) > 0).all()
    for size in (5, 8, 11, 14, 17, 20, 25, 32):
        assert (
            np.diff(
                [of_row(find_gearbox(f"CSF-{size}", ratio)[0]).zones for ratio in (30, 50, 100)],
                axis=0,
            )
            > 0
        ).all()


def test_a_strain_wave_gear_has_no_play_of_its_own():
    """Lost motion of a strain wave gear is elastic: at 4 % of 67 N m a CSF-25-100 winds up 0.59' in
    both directions, of the < 1' printed.
    """
    row, _ = find_gearbox("CSF-25-100")
    part = of_row(row)
    assert part.play.nominal == 0
    lost = 2 * 0.04 * 67 / part.zones[0] / ARCMIN
    assert 0.55 < lost < 1
    assert {"hysteresis", "transmission_error"} == set(row.upper_limits)


@pytest.mark.parametrize("row", [pytest.param(row, id=row.models[0]) for row in RV])
def test_play_and_friction_of_an_rv_make_the_printed_loop(row: GearboxRow):
    """At zero torque the loop is as wide as on the sheet, 1' (1.5' for size 6); the part that is
    not play is friction.
    """
    part = of_row(row)
    printed = 1.5 if row.models == ["RV-6E"] else 1.0
    assert part.lost_motion / ARCMIN == pytest.approx(printed)
    assert part.lost_motion_torque == pytest.approx(0.03)
    assert (part.play.nominal + part.hysteresis) / ARCMIN == pytest.approx(printed, abs=6e-4)
    assert part.play.nominal / ARCMIN == pytest.approx(
        printed - 0.06 * part.rated_torque / (part.zones[0] * ARCMIN), rel=1e-9
    )


def test_an_rv_42n_winds_up_by_its_rating_over_its_rigidity():
    """At its rated 412 N m an RV-42N winds up by 412/113 = 3.65'."""
    part = of_row(find_gearbox("RV-42N")[0])
    assert _wind_up(part, 412.0) == pytest.approx(412 / 113 * math.pi / 180 / 60, rel=1e-12)


def test_larger_sizes_are_stronger_and_stiffer():
    """From size to size an RV carries more and is stiffer, about its axis and against tilting; all
    wind up between 2.5' and 5' at their rating.
    """
    rows = RV[1:]
    parts = [of_row(row) for row in rows]
    assert all(np.diff([part.rated_torque for part in parts]) > 0)
    assert all(np.diff([part.zones[0] for part in parts]) > 0)
    assert all(np.diff([row.moment_rigidity for row in rows]) > 0)
    assert all(2.5 < part.rated_torque / part.zones[0] / ARCMIN < 5 for part in parts)


@pytest.mark.parametrize(
    ("name", "beside", "ratio", "in_row"),
    [
        ("RV-40E", None, None, "any ratio"),
        ("RV-40E-121", None, 121, "any ratio"),
        ("RV-40E", 121.0, 121, "any ratio"),
        ("RV-40E-121", 121.0, 121, "any ratio"),
        ("RV-40E-118.5", None, 118.5, "any ratio"),
        ("CSG-25-100", None, 100, "above 50"),
        ("HFUC-25", 50.0, 50, "50"),
        ("CSF-25-30", None, 30, "30"),
    ],
)
def test_a_name_leads_to_its_row(name: str, beside: float | None, ratio: float | None, in_row: str):
    """The ratio is appended to the name as makers print it, or stated separately; it may be omitted
    where the stiffness does not depend on it.
    """
    row, found = find_gearbox(name, beside)
    assert found == ratio
    assert row.ratios == in_row


@pytest.mark.parametrize(
    ("name", "beside", "expected", "near"),
    [
        ("RV-40", None, "a reducer of the catalogue", "RV-40E"),
        ("rv-40e-121", None, "a reducer of the catalogue", ""),
        ("CSG-26-100", None, "a reducer of the catalogue", "CSG-"),
        ("CSF-25", None, "30, 50 or above 50", ""),
        ("CSF-25-40", None, "30, 50 or above 50", ""),
        ("CSG-25-30", None, "50 or above 50", ""),
        ("CSG-40-30", None, "50 or above 50", ""),
        ("RV-40E-121", 81.0, "one ratio", ""),
        ("", None, "a reducer of the catalogue", ""),
        ("-", None, "a reducer of the catalogue", ""),
        ("RV-40E-", None, "a reducer of the catalogue", "RV-40E"),
        ("x" * 5000, None, "a reducer of the catalogue", ""),
    ],
)
def test_an_unknown_name_is_refused_with_the_nearest(
    name: str, beside: float | None, expected: str, near: str
):
    """The message has the nearest known name, or the ratios with figures; its example is valid."""
    with pytest.raises(InputError) as caught:
        find_gearbox(name, beside)
    (problem,) = caught.value.problems
    assert expected in problem.expected
    assert find_gearbox(problem.example)
    assert not near or problem.nearest.startswith(near)


def test_stated_values_have_priority_over_the_catalogue():
    """A measured backlash replaces the printed lost motion, a single stiffness the zones, and vice
    versa.
    """
    assert of_row(find_gearbox("RV-40E")[0], backlash="0.4 arcmin").play.nominal == pytest.approx(
        0.4 * ARCMIN
    )
    assert of_row(find_gearbox("CSG-25-100")[0], stiffness="40e3 N m/rad").zones == [40e3]
    tighter = of_row(find_gearbox("RV-40E")[0], lost_motion="0.5 arcmin")
    assert (tighter.lost_motion_torque, tighter.stiffness) == (0.03, pytest.approx(108 / ARCMIN))
    assert (
        of_row(
            find_gearbox("CSG-25-100")[0],
            lost_motion="0.9 arcmin",
            rated_torque="67 N m",
            lost_motion_torque="4 %",
        ).play.nominal
        > 0
    )


def test_a_note_names_what_the_row_does_not_state():
    """The note names upper limits and missing values that the user did not state, and the
    source.
    """
    row, _ = find_gearbox("RV-40E")
    note = row.note("RV-40E-121", {})
    assert "lost_motion and hysteresis are the maker's upper limit" in note
    assert "transmission_error" in note
    assert note.endswith("(not verified, 95 % confidence)")
    own = row.note("RV-40E-121", {"backlash": 0, "transmission_error": 0, "stiffness_scatter": 0})
    assert "hysteresis is the maker's upper limit" in own
    assert "nothing is said" not in own


@pytest.mark.parametrize("row", ROWS)
def test_a_note_fits_a_line_of_the_report(row: GearboxRow):
    """With its longest name a row's note keeps its source within 300 characters."""
    assert len(row.note(max(row.models, key=len) + "-118.55", {})) <= 300
