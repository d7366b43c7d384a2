"""result.json: keys that programs can rely on, and the schema that says which there are."""

import json
from pathlib import Path

import jsonschema
import pytest

import lostmotion
from lostmotion.analyses.result import Result
from lostmotion.reporting.layout import LAYOUT, figures_by_key, key_of, result_schema
from lostmotion.reporting.sheet import Cell, Row, Section

ROOT = Path(__file__).parents[2]
Z_ARM = ROOT / "examples" / "z-arm.toml"


@pytest.fixture(scope="module")
def asked():
    """Ask some questions once."""
    arm = lostmotion.read(Z_ARM)
    return {
        "study": lostmotion.study(ROOT / "examples" / "planar-2r.toml", 16, 20, 3),
        "statics": lostmotion.statics(arm, poses=16),
        "gear": lostmotion.gear(Z_ARM, "A"),
        "bearing": lostmotion.bearing(
            ROOT / "examples" / "bearing" / "6209-pair.toml", bearings=20
        ),
        "catalog": lostmotion.catalog("CSG-25-100"),
    }


@pytest.fixture(scope="module")
def results(asked):
    """Return what they write as result.json."""
    return {name: each.result() for name, each in asked.items()}


def test_the_published_schema_is_the_generated_one():
    """docs/result.schema.json is what `lostmotion schema result` prints."""
    published = (ROOT / "docs" / "result.schema.json").read_text(encoding="utf-8")
    assert published == json.dumps(lostmotion.schema("result"), indent=2, ensure_ascii=False) + "\n"
    jsonschema.Draft202012Validator.check_schema(result_schema())


@pytest.mark.parametrize("question", ["study", "statics", "gear", "bearing", "catalog"])
def test_a_result_fits_the_schema(results, question):
    """Whatever is asked, the layout is the same, with its version."""
    tree = json.loads(json.dumps(results[question], allow_nan=False))
    jsonschema.Draft202012Validator(result_schema()).validate(tree)
    assert results[question]["layout"] == LAYOUT


def test_the_main_figures_have_these_keys(results):
    """A program reads `figures.error.p95.value` with its unit and interval, whatever words the
    table prints.
    """
    figures = results["study"]["figures"]
    assert list(figures["error"]) == [
        *("mean", "standard_deviation", "rms", "p50", "p95", "p99", "largest"),
        *(
            "best_pose_mean",
            "best_pose_p95",
            "worst_pose_mean",
            "worst_pose_p95",
            "root_sum_square",
            "worst_case",
            "rotation_rms",
        ),
    ]
    assert list(figures["iso9283"]) == [
        f"{name}_{figure}"
        for name in ("ap", "rp_iso", "rp_any")
        for figure in ("mean", "p95", "worst_pose_p95")
    ]
    p95 = figures["error"]["p95"]
    assert p95["low"] < p95["value"] < p95["high"]
    assert p95["unit"] == "m"
    assert p95["display"].endswith(")")


def test_every_printed_figure_has_its_key(results):
    """Tables and keys hold the same numbers, section by section, row by row."""
    for result in results.values():
        for section in result["sections"]:
            keyed = result["figures"][section["key"]]
            assert len(keyed) == len(section["rows"])
            for found, row in zip(keyed.values(), section["rows"], strict=True):
                several = [found] if "value" in found else list(found.values())
                assert [each["value"] for each in several] == [
                    each["value"] for each in row["figures"]
                ]


@pytest.mark.parametrize(
    ("label", "key"),
    [
        ("95 % below", "p95"),
        ("95th percentile", "p95"),
        ("95 %", "p95"),
        ("worst pose, 95 % below", "worst_pose_p95"),
        ("AP, 95 % of robots below", "AP_p95"),
        ("A bearing", "A_bearing"),
        ("joint 'x'", "joint_x"),
        ("…", "value"),
    ],
)
def test_a_key_follows_from_its_label(label, key):
    """Letters and digits, with percentiles by their number."""
    assert key_of(label) == key


def test_rows_of_one_name_are_numbered():
    """No figure takes another one's place."""
    row = Row("A", (Cell(1.0, "mm"), Cell(2.0, "%")))
    found = figures_by_key([Section("x", "X", ("now", "now"), (row, row))])
    assert list(found["x"]) == ["A", "A_2"]
    assert [found["x"]["A"][name]["value"] for name in ("now", "now_2")] == [1.0, 2.0]


def test_a_result_shows_itself_in_a_few_lines(asked):
    """At the prompt of Python: what it is, and the figures that are asked for first."""
    for each in asked.values():
        lines = repr(each).splitlines()
        assert lines[0].startswith(f"<{type(each).__name__} of '")
        assert len(lines) < 20
        assert max(map(len, lines)) < 200


def test_no_result_shows_all_its_fields():
    """Whatever a result is computed from, its text is that of results."""
    kinds = [
        kind
        for kind in (getattr(lostmotion, name) for name in lostmotion.__all__)
        if isinstance(kind, type) and issubclass(kind, Result)
    ]
    assert len(kinds) == 18
    for kind in kinds:
        assert kind.__repr__ is Result.__repr__ or "__repr__" in vars(kind)
        assert not kind.__dataclass_params__.repr
