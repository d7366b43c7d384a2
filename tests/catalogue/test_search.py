"""The catalogue searched and shown: rows that meet the criteria, rows that do not state them, whole
entries; in Python and on the command line.
"""

from __future__ import annotations

import json
import math
from pathlib import Path
from typing import TYPE_CHECKING

import pytest

from lostmotion.analyses.catalog.page import catalogue_sheet
from lostmotion.catalogue.gearbox_row import GearboxRow
from lostmotion.catalogue.gearboxes import gearboxes
from lostmotion.catalogue.search import Criteria, search, searchable_figures
from lostmotion.errors import InputError
from tests.catalogue.test_own_reducers import HEAD, ROW, USE
from tests.command import carried_out
from tests.parts.conditions import ARCMIN

if TYPE_CHECKING:
    import subprocess


def names(rows) -> list[str]:
    """Return the first model of each row."""
    return [row.models[0] for row in rows]


def catalog(*words: str, cwd: Path = Path()) -> subprocess.CompletedProcess[str]:
    """Run the command."""
    return carried_out("catalog", *words, cwd=cwd)


# the planetary gear units of ratio 5 that carry 300 N m
FIVE = ["TP050-MF", "TP300-MF", "TP500-MF", "SP180-MF", "SP240-MF", "NPS045-MF", "PLE160"]


@pytest.mark.parametrize(
    ("wanted", "found"),
    [
        (
            Criteria(min_torque=784.0, maker="nab"),
            ["RV-80E", "RV-110E", "RV-160E", "RV-320E", "RV-450E"],
        ),
        (Criteria(min_torque=784.1, min_stiffness=500 / ARCMIN, ratio=121), ["RV-320E", "RV-450E"]),
        (
            Criteria(min_torque=300, ratio=5),
            ["RV-42N", *(f"RV-{size}E" for size in (40, 80, 110, 160, 320, 450)), *FIVE],
        ),
        (Criteria(min_torque=1.0, max_lost_motion=0.9 * ARCMIN), []),
        (
            Criteria(max_lost_motion=ARCMIN, maker="NABTESCO", min_stiffness=400 / ARCMIN),
            ["RV-320E", "RV-450E"],
        ),
        (Criteria(maker="harm", ratio=30, min_stiffness=10e3), ["CSF-25", "CSF-32"]),
        (Criteria(maker="harm", ratio=30.5), []),
    ],
)
def test_rows_that_meet_the_criteria_are_found(wanted: Criteria, found: list[str]):
    """A figure equal to the limit meets it; all criteria must be met; the softest zone counts."""
    assert names(search(gearboxes(), wanted).rows) == found


def test_rows_without_a_figure_are_listed_separately():
    """Every row of the package states a rated torque; own rows without one are listed separately,
    less those that fail by a stated figure.
    """
    assert not search(gearboxes(), Criteria(min_torque=1.0)).not_stated
    parts = {"soft": {"stiffness": "1 N m/arcmin"}, "stiff": {"stiffness": "100 N m/arcmin"}}
    own = [
        GearboxRow.model_validate({"models": [name], "maker": "X", "part": part, "source": "none"})
        for name, part in parts.items()
    ]
    assert names(search(own, Criteria(min_torque=1.0)).not_stated["rated torque"]) == [
        "soft",
        "stiff",
    ]
    assert names(
        search(own, Criteria(min_torque=1.0, min_stiffness=300e3)).not_stated["rated torque"]
    ) == ["stiff"]
    backlash_only = search(gearboxes(), Criteria(max_lost_motion=2 * ARCMIN)).not_stated
    assert {row.maker for row in backlash_only["lost motion"]} == {
        "Beckhoff (Wittenstein)",
        "Beckhoff (Neugart)",
    }


def test_search_agrees_with_every_row_checked_one_by_one():
    """Every row is found, listed separately, or fails a limit by a stated figure; none is lost."""
    for torque in (50.0, 500.0):
        for stiffness in (1e4, 3e5):
            found = search(gearboxes(), Criteria(min_torque=torque, min_stiffness=stiffness))
            kept = {
                id(row)
                for row in (
                    *found.rows,
                    *(row for rows in found.not_stated.values() for row in rows),
                )
            }
            for row in gearboxes():
                figures = searchable_figures(row)
                fails = figures["rated torque"] < torque or figures["stiffness"] < stiffness
                assert (id(row) not in kept) == fails
    assert all(
        math.isnan(searchable_figures(row)["lost motion"]) == row.maker.startswith("Beckhoff")
        for row in gearboxes()
    )


def test_a_row_without_any_figure_is_listed_under_all():
    """A row that states nothing is listed under every required figure."""
    row = GearboxRow.model_validate({"models": ["X"], "maker": "X", "part": {}, "source": "none"})
    found = search([row], Criteria(min_torque=1.0, min_stiffness=1.0, max_lost_motion=1.0))
    assert (found.rows, set(found.not_stated)) == ((), {"rated torque", "stiffness", "lost motion"})


def test_an_unknown_maker_is_refused():
    """The message has the nearest one."""
    with pytest.raises(InputError, match="Nabtesco"):
        search(gearboxes(), Criteria(maker="Nabtasco"))


ENTRIES = [
    *dict.fromkeys(row.models[-1] for row in gearboxes()),
    "RV-40E-121",
    "CSF-25-100",
    "steel",
    "PLA",
    "shaft",
    "deep-groove ball",
]


@pytest.mark.parametrize("name", ENTRIES)
def test_every_entry_can_be_shown_whole(name: str):
    """Each has a section with its source."""
    sheet = catalogue_sheet(Criteria(), name=name)
    assert sheet.sections
    for section in sheet.sections:
        told = " ".join(f"{row.label} {row.note}" for row in section.rows) + section.note
        assert "(verified)" in told or "(not verified, " in told
    json.dumps(sheet.facts)


def test_a_name_without_its_ratio_shows_all_its_rows():
    """CSF-25 has three rows; with a ratio it is one."""
    assert len(catalogue_sheet(Criteria(), name="CSF-25").sections) == 3
    (section,) = catalogue_sheet(Criteria(ratio=30), name="CSF-25").sections
    assert {row.label: row.note for row in section.rows}[
        "in an arm file"
    ] == 'gearbox = "CSF-25-30"'
    with pytest.raises(InputError, match="30, 50 or above 50"):
        catalogue_sheet(Criteria(ratio=40), name="CSF-25")


def test_the_whole_catalogue_is_shown_without_criteria():
    """Reducers by source, bearing tables, fits, materials, presets; with a kind, that kind
    alone.
    """
    keys = [section.key for section in catalogue_sheet(Criteria()).sections]
    assert keys == ["gearboxes"] * 9 + ["bearings"] * 2 + ["materials", "presets"]
    assert {section.key for section in catalogue_sheet(Criteria(), "bearing").sections} == {
        "bearings"
    }
    assert {section.key for section in catalogue_sheet(Criteria(min_torque=1.0)).sections} == {
        "gearboxes"
    }
    facts = catalogue_sheet(Criteria()).facts
    assert len(facts["gearboxes"]) == len(gearboxes())
    assert facts["bearings"] == [
        "deep-groove ball",
        "cylindrical roller",
        "shaft",
        "bearing bore",
        "housing",
        "bearing outside",
    ]
    assert "PLA" in facts["materials"]
    with pytest.raises(InputError, match="figures of gearboxes"):
        catalogue_sheet(Criteria(min_torque=1.0), "material")
    with pytest.raises(InputError, match="not both"):
        catalogue_sheet(Criteria(min_torque=1.0), name="RV-40E")


def test_the_command_searches_and_names_rows_without_a_figure():
    """A table with source and confidence, and a note on the rows that do not state a required
    figure.
    """
    done = catalog("--min-torque", "300 N m", "--max-lost-motion", "1 arcmin")
    assert done.returncode == 0, done.stderr
    for words in (
        "12 reducers",
        "RV-450E",
        "4410 N m",
        "CSG-58",
        "not verified, 95 % confidence",
        "(verified)",
        "17 more rows do not state lost motion",
    ):
        assert words in " ".join(done.stdout.split())
    assert "RV-20E" not in done.stdout


def test_the_command_writes_json():
    """The same as JSON, figures with their units."""
    data = json.loads(catalog("--min-torque", "4000 N m", "--json").stdout)
    planetary = json.loads(catalog("--maker", "neugart", "--json").stdout)["gearboxes"]
    assert planetary[-1]["ratio_one_of"] == [3, 4, 5, 8]
    assert [row["models"] for row in data["gearboxes"]] == [["RV-450E"]]
    assert data["gearboxes"][0]["figures"]["rated torque"] == {"value": 4410.0, "unit": "N m"}
    assert data["gearboxes"][0]["confidence"] == "M 95"
    assert data["not_stated"] == {}
    assert json.loads(catalog("aluminium", "--json").stdout)["entries"][0]["young"] == "70 GPa"


def test_the_command_searches_own_rows(tmp_path):
    """A file of rows has priority over the package's, brackets in its texts are not markup; a
    mistake in it is reported.
    """
    (tmp_path / "my.toml").write_text(
        ROW.replace("measured", "[/bold] measured [red]").replace('"X"', '"[/b] X"'),
        encoding="utf-8",
    )
    done = catalog("--file", "my.toml", "--min-torque", "50 N m", cwd=tmp_path)
    assert done.stdout.index("X-10") < done.stdout.index("RV-42N")
    assert "[/b] X" in done.stdout
    assert "[/bold] measured [red] on 5 pieces" in done.stdout
    assert "[/bold] measured" in catalog("X-10", "--file", "my.toml", cwd=tmp_path).stdout
    (tmp_path / "arm.toml").write_text(HEAD + USE + ROW, encoding="utf-8")
    assert "X-10" in catalog("--file", "arm.toml", "--maker", "x", cwd=tmp_path).stdout
    (tmp_path / "my.toml").write_text(ROW.replace("maker", "makr"), encoding="utf-8")
    wrong = catalog("--file", "my.toml", cwd=tmp_path)
    assert wrong.returncode == 2
    assert "reducers[0].makr" in wrong.stderr


@pytest.mark.parametrize(
    ("words", "said"),
    [
        (("--min-torque", "300"), "--min-torque"),
        (("--min-torque", "3 kg"), "is not a unit of torque"),
        (("--max-lost-motion", "0 arcmin"), "above zero"),
        (("--min-stiffness", "50 N m"), "angular stiffness"),
        (("--ratio", "100 ± 1"), "a tolerance is not used here"),
        (("--ratio", "x"), "--ratio"),
        (("--maker", "Nabtasco"), "Nabtesco"),
        (("--kind", "gear"), "gearbox"),
        (("aluminum",), "did you mean 'aluminium'"),
        (("RV-41E",), "did you mean 'RV-40E'"),
        (("--kind", "gearbox", "aluminium"), "a reducer of the catalogue"),
        (("--file", "nowhere.toml"), "no such file"),
    ],
)
def test_an_impossible_request_is_refused(words: tuple[str, ...], said: str, tmp_path):
    """Exit code 2, one clear message, no traceback."""
    done = catalog(*words, cwd=tmp_path)
    assert done.returncode == 2
    assert said in done.stderr
    assert "Traceback" not in done.stderr


@pytest.mark.parametrize(
    ("word", "expected"),
    [
        ("backlash", "`lostmotion catalog` lists them"),
        ("play", "`lostmotion catalog` lists them"),
        ("dynamixel", "Dynamixel XL430, Dynamixel XM430, Dynamixel XM540"),
        ("stel", "did you mean 'steel'"),
    ],
)
def test_an_unknown_name_has_a_short_answer(word, expected):
    """The names that contain the word, or the nearest one, or where all are listed; never all of
    them.
    """
    with pytest.raises(InputError) as caught:
        catalogue_sheet(Criteria(), name=word)
    text = str(caught.value)
    assert expected in text
    assert len(text) < 400
