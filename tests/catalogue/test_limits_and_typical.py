"""Catalogue values that are a maker's upper limits, and the typical values that a file may select
instead.
"""

from __future__ import annotations

import pytest

from lostmotion.catalogue.gearbox_row import source_in_words
from lostmotion.catalogue.gearboxes import find_gearbox, gearboxes
from lostmotion.io import read
from tests.io.conftest import JOINT, mistakes_in  # noqa: F401 - the fixture
from tests.parts.conditions import ARCMIN, local_screws

HEAD = 'name = "x"\n'
ROW = (
    '[[reducers]]\nmodels = ["X-10"]\nmaker = "X"\nupper_limits = ["hysteresis"]\nsource = '
    '"data sheet"\n'
    'part = { rated_torque = "50 N m", stiffness = "20 N m/arcmin", hysteresis = "1 arcmin" }\n'
)
TYPICAL = 'typical = { hysteresis = "0.1 arcmin", source = "measured on 5 pieces" }\n'


def arm_from(tmp_path, text):
    """Read an arm from text."""
    path = tmp_path / "arm.toml"
    path.write_text(HEAD + text, encoding="utf-8")
    return read(path)


def test_a_file_selects_limit_or_typical(tmp_path):
    """The limit is the default and is named as one; the typical value is assumed, with its own
    source.
    """
    limit = arm_from(tmp_path, JOINT + 'gearbox = { catalogue = "X-10" }\n' + ROW + TYPICAL)
    also = arm_from(
        tmp_path, JOINT + 'gearbox = { catalogue = "X-10", values = "limit" }\n' + ROW + TYPICAL
    )
    typical = arm_from(
        tmp_path, JOINT + 'gearbox = { catalogue = "X-10", values = "typical" }\n' + ROW + TYPICAL
    )
    assert limit.moving[0].gearbox == also.moving[0].gearbox
    assert limit.moving[0].gearbox.hysteresis == pytest.approx(ARCMIN)
    assert limit.moving[0].gearbox.upper_limits == ("hysteresis",)
    assert (
        'hysteresis is the maker\'s upper limit; for hysteresis values = "typical" is known'
        in limit.notes[0]
    )
    gearbox = typical.moving[0].gearbox
    assert gearbox.hysteresis == pytest.approx(0.1 * ARCMIN)
    assert (gearbox.upper_limits, gearbox.assumed) == ((), ("hysteresis",))
    assert "measured on 5 pieces" in gearbox.source
    assert "hysteresis typical (measured on 5 pieces)" in typical.notes[0]


def test_a_typical_loop_is_narrower_by_its_share(tmp_path):
    """A loop of 0.1' in the place of one of 1' moves the tool by a tenth."""
    sizes = []
    for values in ("limit", "typical"):
        arm = arm_from(
            tmp_path,
            JOINT + f'gearbox = {{ catalogue = "X-10", values = "{values}" }}\n' + ROW + TYPICAL,
        )
        sizes.append(
            sum(
                abs(screw).max()
                for of, screw in local_screws(arm, [[0.3]])
                if of.term.cause == "hysteresis"
            )
        )
    assert sizes[1] == pytest.approx(0.1 * sizes[0])


def test_stated_values_have_priority_over_typical_ones(tmp_path):
    """A loop that the user measured is used with either selection, and is not assumed."""
    arm = arm_from(
        tmp_path,
        JOINT
        + 'gearbox = { catalogue = "X-10", values = "typical", hysteresis = "0.4 arcmin" }\n'
        + ROW
        + TYPICAL,
    )
    assert arm.moving[0].gearbox.hysteresis == pytest.approx(0.4 * ARCMIN)
    assert arm.moving[0].gearbox.assumed == ()


def test_strain_wave_gears_repeat_to_a_tenth_of_a_minute(tmp_path):
    """The makers print a hysteresis below 1' and a repeatability of ±0.1': the typical loop is 0.2'
    wide.
    """
    arm = arm_from(tmp_path, JOINT + 'gearbox = { catalogue = "CSG-25-100", values = "typical" }\n')
    assert arm.moving[0].gearbox.hysteresis == pytest.approx(0.2 * ARCMIN)
    assert arm.moving[0].gearbox.upper_limits == ("transmission_error",)


@pytest.mark.parametrize(
    ("text", "key", "expected"),
    [
        (
            'gearbox = { catalogue = "X-10", values = "nominal" }\n' + ROW + TYPICAL,
            "joints.A.gearbox.values",
            "limit",
        ),
        (
            'gearbox = { catalogue = "X-10", values = 3 }\n' + ROW + TYPICAL,
            "joints.A.gearbox.values",
            "limit",
        ),
        (
            'gearbox = { catalogue = "X-10", values = "typical" }\n' + ROW,
            "joints.A.gearbox.values",
            "knows typical values",
        ),
        (
            'gearbox = { ratio = 3, values = "typical" }\n',
            "joints.A.gearbox.values",
            "catalogue with a maker's name",
        ),
        (
            'gearbox = "g"\n[gearboxes.g]\nvalues = "typical"\n',
            "gearboxes.g.values",
            "catalogue with a maker's name",
        ),
        (ROW + TYPICAL.replace("hysteresis", "backlash"), "reducers[0]", "upper_limits"),
        (ROW + TYPICAL.replace("0.1", "1.1"), "reducers[0]", "at most the limit"),
        (ROW + TYPICAL.replace("0.1 arcmin", "0.1"), "reducers[0].typical.hysteresis", "angle"),
        (
            ROW + TYPICAL.replace("hysteresis", "hysteresys"),
            "reducers[0].typical.hysteresys",
            "hysteresis",
        ),
        (ROW + 'typical = { hysteresis = "0.1 arcmin" }\n', "reducers[0].typical.source", "text"),
        (ROW + "typical = 3\n", "reducers[0].typical", "table"),
        (
            ROW + 'inertia_by_ratio = { "57" = "3 kg" }\n',
            "reducers[0].inertia_by_ratio.57",
            "moment of inertia",
        ),
        (ROW + 'inertia_by_ratio = { "x" = "3 kg m^2" }\n', "reducers[0]", "ratios as keys"),
    ],
)
def test_a_slip_is_one_mistake_under_its_key(mistakes_in, text, key, expected):  # noqa: F811 - the fixture
    """A wrong selection, a typical value of no limit or above it, and one without a source are
    refused under their key.
    """
    found = mistakes_in(HEAD + JOINT + text)
    assert list(found) == [key]
    assert expected in found[key].expected


@pytest.mark.parametrize(
    "row", [pytest.param(row, id=f"{row.models[0]}, ratio {row.ratios}") for row in gearboxes()]
)
def test_every_typical_value_and_every_mass_of_the_package_has_a_source(row):
    """Every figure has its source: typical values are below the limits, masses and moments of
    inertia grow with the size.
    """
    assert row.figures.part.mass > 0
    assert row.source
    if row.typical:
        assert row.typical["source"].endswith("]")
        assert row.figures.typical.hysteresis < row.figures.part.hysteresis
    if row.inertia_by_ratio:
        ratios = [float(ratio) for ratio in row.inertia_by_ratio]
        assert ratios == sorted(ratios)
        inertias = list(row.inertia_by_ratio.values())
        # a larger first-stage ratio goes with a smaller input pinion
        assert inertias == sorted(inertias, reverse=True)
    assert (
        row.inertia_by_ratio
        or row.figures.part.inertia
        or row.models == ["RV-42N"]
        or row.maker.startswith("Beckhoff")
    )


@pytest.mark.parametrize(
    "row", [pytest.param(row, id=f"{row.models[0]}, ratio {row.ratios}") for row in gearboxes()]
)
@pytest.mark.parametrize("values", ["limit", "typical"])
def test_a_source_is_printed_whole(row, values):
    """The source of a catalogue gearbox ends with that of its moment of inertia or mass, to its
    last word.
    """
    ratio = next(iter(row.inertia_by_ratio), "118.5")
    last = source_in_words(row.inertia_source or row.mass_source or row.source)
    assert row.with_stated({"ratio": float(ratio)}, values)["source"].endswith(last)


def test_larger_sizes_weigh_more():
    """Within each series mass and the moment of inertia at the input rise with the size."""
    for series in ("RV", "CSF", "CSG"):
        rows = [
            row
            for row in gearboxes()
            if row.models[0].startswith(series)
            and row.models != ["RV-42N"]
            and (row.ratio_above or series == "RV")
        ]
        masses = [row.figures.part.mass for row in rows]
        assert len(masses) == 8
        assert masses == sorted(masses)
        inertias = [row.figures.part.inertia for row in rows if row.ratio_above]
        assert inertias == sorted(inertias)


def test_the_moment_of_inertia_depends_on_the_ratio(tmp_path):
    """An RV-40E-121 has 0.137 kg cm^2 at its input; for a ratio that is not printed it is
    unknown.
    """
    arm = arm_from(
        tmp_path,
        JOINT
        + 'gearbox = "RV-40E-121"\n'
        + JOINT.replace('"A"', '"B"')
        + 'gearbox = "RV-40E-122"\n',
    )
    assert [joint.gearbox.inertia for joint in arm.moving] == [pytest.approx(1.37e-5), None]


def test_figures_from_memory_are_assumed_with_their_confidence():
    """The stiffness of an RV-20E was not verified, that of an RV-42N was; a user's own value is a
    fact in either.
    """
    memory, read_there = (find_gearbox(name)[0].with_stated({}) for name in ("RV-20E", "RV-42N"))
    assert "stiffness" in memory["assumed"]
    assert "rated_torque" in memory["assumed"]
    assert "not verified, 95 % confidence" in memory["source"]
    assert read_there["assumed"] == ["mass"]
    assert (
        "mass: Nabtesco, RV-N series, rating table (not verified, 85 % confidence)"
        in read_there["source"]
    )
    assert (
        "stiffness"
        not in find_gearbox("RV-20E")[0].with_stated({"stiffness": "50 N m/arcmin"})["assumed"]
    )
