"""Sizing from the file to the folder: request, tables, plots and files."""

from __future__ import annotations

import json
import math
import re
from pathlib import Path
from types import SimpleNamespace

import pytest

import lostmotion
from lostmotion.analyses.sizing.page.plots import sizing_plots
from lostmotion.io import sizing as request
from lostmotion.io.arm_writer import reads_back, sized_text
from lostmotion.io.sizing import read_request
from lostmotion.parts.section import Tube
from lostmotion.reporting.layout import row_at
from tests.command import carried_out

EXAMPLES = Path(__file__).parents[3] / "examples"
Z_ARM = EXAMPLES / "z-arm.toml"
ONE_LINK = """
name = "cantilever"
[payload]
mass = "5 kg"
[[joints]]
name = "A"
type = "revolute"
axis = "y"
limits = ["-90 deg", "90 deg"]
link = { length = "500 mm", mass = "0 kg", section = { kind = "tube", outer = "40 mm", wall = "2 mm" }, material = "aluminium" }
"""

ODD = """
name = "odd"
sections.one = { kind = "tube", outer = "80 mm", wall = "3 mm" }
joints = [
  { name = "A", type = "revolute", axis = "y", limits = ["-1 rad", "1 rad"], link = { length = "300 mm", section = "one", material = "aluminium" } },
  { name = "B", type = "revolute", axis = "y", limits = ["-1 rad", "1 rad"], link = { length = "200 mm", section = "one", material = "aluminium" } },
]
payload.mass = "4 kg"
"""


def ran(*words, cwd):
    """Run the command in a folder."""
    return carried_out("size", *words, cwd=cwd)


@pytest.fixture(scope="module")
def size():
    """Return the paper's arm with sized links."""
    return lostmotion.size(Z_ARM, poses=16)


def asked(tmp_path, text, arm=None, **options):
    """Read a sizing file for the paper's arm."""
    path = tmp_path / "by.toml"
    path.write_text(text, encoding="utf-8")
    asked = read_request(path, options, arm or lostmotion.read(Z_ARM))
    return asked.plan, asked.link_options


def test_the_sheet_agrees_with_the_sized_arm(size):
    """Masses, slopes and the trade-off on the sheet are those of the arm that was sized, and the
    paper's limits are named.
    """
    sheet, found = size.sheet, size
    for link in found.links:
        now, then = (
            figure.value for figure in row_at(sheet.sections, "sections", link.joint).cells
        )
        assert now == next(
            joint.link.total_mass for joint in found.arm.joints if joint.name == link.joint
        )
        assert then == next(
            joint.link.total_mass for joint in found.sized.joints if joint.name == link.joint
        )
        taken = [row_at(sheet.sections, "bending", link.joint).cells[k].as_shown for k in (1, 3)]
        assert max(taken) == pytest.approx(100 * max(link.utilisation))
        assert 70 < max(taken) <= 100  # usual sizes, so not quite up to the limit
    assert row_at(sheet.sections, "trade", "0_5_arcmin_length_2500").note == "the paper's limits"
    assert "Slope governs at every link" in sheet.verdict
    assert {plot.section for plot in sizing_plots(found)} <= {
        section.key for section in sheet.sections
    }
    json.dumps(size.result(), allow_nan=False)


@pytest.mark.usefixtures("few_scales")
def test_sizes_are_usual_ones_unless_a_step_is_asked_for(size):
    """By default the Z-arm gets tubes that are sold; `step` gives its multiples, zero the exact
    size, which is lighter. Each is checked again.
    """
    assert [link.section.outer for link in size.links] == pytest.approx([0.13, 0.13, 0.095, 0.055])
    exact, tenths = (lostmotion.size(Z_ARM, poses=16, step=step) for step in ("0 mm", "0.1 mm"))
    masses = [sum(link.mass for link in each.links) for each in (exact, tenths, size)]
    assert masses == sorted(masses)
    assert all(
        round(link.section.outer * 1e4) == pytest.approx(link.section.outer * 1e4)
        for link in tenths.links
    )
    assert all(
        each.meets_limits and each.validated_utilisation <= 1.001 for each in (exact, tenths, size)
    )


@pytest.mark.usefixtures("few_scales")
def test_one_link_is_spoken_of_as_one(tmp_path):
    """An arm with one link has 'the sized link', not 'every link'."""
    (tmp_path / "arm.toml").write_text(ONE_LINK, encoding="utf-8")
    sheet = lostmotion.size(tmp_path / "arm.toml", poses=8).sheet
    assert "The mass of the sized link is " in sheet.verdict
    assert "Slope governs the link of A." in sheet.verdict
    assert "at its worst pose" in sheet.verdict
    assert not re.search(
        r"\blinks\b|every link|1 poses",
        sheet.verdict + sheet.counts + " ".join(card.title for card in sheet.cards),
    )


def test_the_sized_arm_reads_back_with_its_comments(size, tmp_path):
    """sized.toml is the user's file with other sections: it reads as the sized arm, keeps the
    comments, and the input is not touched.
    """
    before = Z_ARM.read_bytes()
    folder = size.report(tmp_path / "out")
    assert Z_ARM.read_bytes() == before
    written = folder / "sized.toml"
    assert not reads_back(Z_ARM, written, size)
    again = lostmotion.read(written)
    for one, other in zip(again.joints, size.sized.joints, strict=True):
        assert one.link.total_mass == pytest.approx(other.link.total_mass, rel=1e-12)
        assert one.gearbox == other.gearbox
    text = written.read_text(encoding="utf-8")
    assert "# paper: working clearance up to 60 µm" in text
    assert "sections.large" not in text
    assert not again.notes
    assert sorted(path.name for path in folder.iterdir()) == [
        "report.html",
        "result.json",
        "sized.toml",
    ]


@pytest.mark.usefixtures("few_scales", "unpainted")
def test_a_urdf_is_sized_by_its_sidecar(tmp_path):
    """Of a URDF the sized sections go into a sidecar, with the masses that follow; the URDF with it
    is the sized arm.
    """
    source = EXAMPLES / "ur5e.urdf"
    size = lostmotion.size(source, poses=8)
    assert size.meets_limits
    folder = size.report(tmp_path / "out")
    assert not reads_back(source, folder / "sized.toml", size)


@pytest.mark.usefixtures("few_scales", "unpainted")
def test_a_urdf_without_a_sidecar_gets_one(tmp_path):
    """Of a bare URDF, links get sections where a family and a material are named; their masses
    remain, and the report notes it.
    """
    source = tmp_path / "bare.urdf"
    source.write_bytes((EXAMPLES / "ur5e.urdf").read_bytes())
    family = {"kind": "tube", "outer": "30 mm .. 200 mm", "wall": "3 mm"}
    size = lostmotion.size(source, {"family": family, "material": "aluminium"}, poses=8)
    assert all(link.mass > link.mass_before for link in size.links)
    assert any("is added to that mass" in note for note in size.sheet.notes)
    folder = size.report(tmp_path / "out")
    assert not reads_back(source, folder / "sized.toml", size)
    with pytest.raises(lostmotion.InputError, match="no link to size"):
        lostmotion.size(lostmotion.read(source), poses=8)


@pytest.mark.usefixtures("few_scales")
def test_a_bare_layout_is_written_too(tmp_path):
    """Dotted keys, links in tables of their own and sections that others still name are written and
    read back as the sized arm.
    """
    path = tmp_path / "odd.toml"
    path.write_text(ODD, encoding="utf-8")
    size = lostmotion.size(path, {"links": {"B": {"keep": True}}}, poses=8)
    assert [link.joint for link in size.links] == ["A"]
    out = tmp_path / "sized.toml"
    out.write_text(sized_text(path, None, size), encoding="utf-8")
    assert not reads_back(path, out, size)
    assert lostmotion.read(out).joints[1].link.section == Tube(outer="80 mm", wall="3 mm")


def test_a_file_states_the_options_of_each_link(tmp_path):
    """Families, lists, materials and `keep`: each link has the options of its own table, the others
    those for all.
    """
    plan, wanted = asked(
        tmp_path,
        """
[sizing]
slope = "1 arcmin"
deflection = 1000
tilt = "5 deg"
family = { kind = "tube", outer = "30 mm .. 200 mm", wall = "5 %" }
[sizing.links.A]
stock = [{ kind = "tube", outer = "100 mm", wall = "3 mm" }, { kind = "rod", diameter = "80 mm" }]
[sizing.links.B]
material = "steel"
[sizing.links.roll]
keep = true
""",
    )
    assert (plan.deflection, round(plan.slope, 9)) == (1000, 0.000290888)
    assert sorted(wanted) == ["A", "B", "O"]
    assert len(wanted["A"].choice) == 2
    assert wanted["B"].material.young == 210e9
    assert wanted["O"].choice.kind == "tube"
    assert wanted["O"].choice.wall.share


def test_every_mistake_is_reported_at_once(tmp_path):
    """Mistakes in limits, families, lists, names of links and materials come in one message, each
    under its key.
    """
    with pytest.raises(lostmotion.InputError) as caught:
        asked(
            tmp_path,
            """
extra = 1
[sizing]
slope = "0.5 mm"
tlt = "10 deg"
material = "alumnium"
family = { kind = "tube", outer = "200 mm .. 30 mm", wall = "3" }
[sizing.links.Q]
keep = true
[sizing.links.B]
stock = [{ kind = "tube", outer = "80 mm", wall = "50 mm" }]
[sizing.links.A]
family = { kind = "rod", diameter = "5 %" }
""",
        )
    keys = {problem.key for problem in caught.value.problems}
    assert keys == {
        "extra",
        "sizing.slope",
        "sizing.tlt",
        "sizing.material",
        "sizing.family.outer",
        "sizing.family.wall",
        "sizing.links.Q",
        "sizing.links.B.stock[0]",
        "sizing.links.A.family",
    }
    assert (
        next(each for each in caught.value.problems if each.key == "sizing.tlt").nearest == "tilt"
    )


@pytest.mark.parametrize(
    "text",
    [
        "",
        "sizing = 3",
        "[sizing]\nlinks = 3",
        "[sizing]\nlinks.A = 3",
        '[sizing]\nfamily = { kind = "tube", outer = "30 mm .. 40 mm .. 50 mm", wall = "3 mm" }',
        '[sizing]\nfamily = { kind = "tube", outer = "1e400 mm", wall = "3 mm" }',
        '[sizing]\nfamily = { kind = "tube", outer = 3, wall = [] }',
        '[sizing]\nfamily = { kind = "tube", outer = "10 mm", wall = "8 mm" }',
        '[sizing]\nfamily = { kind = "cone" }',
        "[sizing]\nstock = []",
        "[sizing]\nkeep = true",
        '[sizing.links.C]\nfamily = { kind = "rod", diameter = "30 mm" }',
        '[sizing]\nkeep = true\nfamily = { kind = "rod", diameter = "30 mm" }',
    ],
)
def test_hostile_files_are_refused_with_one_message(tmp_path, text):
    """Any invalid file gives a list of mistakes."""
    with pytest.raises(lostmotion.InputError):
        asked(tmp_path, text)


def test_an_option_and_a_key_of_the_file_exclude_each_other(tmp_path):
    """What both the file and an option state is refused; a mistake in an option has the option's
    name.
    """
    with pytest.raises(lostmotion.InputError, match="slope"):
        asked(tmp_path, '[sizing]\nslope = "1 arcmin"', slope="0.5 arcmin")
    with pytest.raises(lostmotion.InputError) as caught:
        asked(tmp_path, "[sizing]", family={"kind": "tube", "outer": "3 mm"}, slope="4 mm")
    assert {problem.key for problem in caught.value.problems} == {"wall", "slope"}


@pytest.mark.parametrize(
    "tube",
    [
        {"outer": "30 mm .. 20 mm"},
        {"outer": "30 mm .. 20 mm", "wall": "3 mm"},
        {"wall": "6 mm .. 2 mm"},
    ],
)
def test_one_mistake_gives_one_message(tmp_path, tube):
    """A falling range is the only message, with or without the other size; a missing size has its
    own message with an example.
    """
    with pytest.raises(lostmotion.InputError) as caught:
        asked(tmp_path, "[sizing]", family={"kind": "tube", **tube})
    assert [problem.found for problem in caught.value.problems] == [
        f"'{next(iter(tube.values()))}' (a range that does not rise)"
    ]
    with pytest.raises(lostmotion.InputError) as caught:
        asked(tmp_path, "[sizing]", family={"kind": "tube", "outer": "30 mm .. 200 mm"})
    assert [(problem.key, problem.passing) for problem in caught.value.problems] == [
        ("wall", (("wall", "3 mm"),))
    ]


def test_sizes_and_limits_are_numbers_in_si_too(monkeypatch):
    """From Python a number is SI, in limits, families, lists and links; numbers that are none are
    refused under their name.
    """
    seen = []
    monkeypatch.setattr(
        request, "read_request", lambda *said: seen.append(read_request(*said)) or seen[-1]
    )
    monkeypatch.setattr(
        "lostmotion.analyses.sizing.sizing.size_links", lambda *_said, **_more: SimpleNamespace()
    )
    monkeypatch.setattr(
        "lostmotion.analyses.sizing.command.replace", lambda *_found, **_files: None
    )
    arm = lostmotion.read(Z_ARM)
    said = {
        "slope": "1 arcmin",
        "tilt": "10 deg",
        "step": "1 mm",
        "family": {"kind": "tube", "outer": "30 mm .. 200 mm", "wall": "3 mm"},
    }
    in_si = {
        "slope": math.radians(1 / 60),
        "tilt": math.radians(10),
        "step": 1e-3,
        "family": {"kind": "tube", "outer": (0.03, "20 cm"), "wall": 0.003},
    }
    links = (
        {"A": {"stock": [{"kind": "tube", "outer": "80 mm", "wall": "2 mm"}]}},
        {"A": {"stock": [{"kind": "tube", "outer": 0.08, "wall": 0.002}]}},
    )
    for words, each in zip((said, in_si), links, strict=True):
        lostmotion.size(arm, {"links": each, **words}, poses=8)
    first, second = (found.plan for found in seen)
    assert [second.slope, second.tilt, second.step] == pytest.approx(
        [first.slope, first.tilt, first.step]
    )
    assert second.family == first.family
    assert seen[0].link_options["A"] == seen[1].link_options["A"]
    for wrong in ({"slope": math.nan}, {"tilt": "10 mm"}, {"target": -1}, {"step": True}):
        with pytest.raises(lostmotion.InputError, match=next(iter(wrong))):
            lostmotion.size(arm, wrong)


@pytest.mark.usefixtures("unpainted")
def test_sizing_works_out_of_the_box(tmp_path):
    """`lostmotion size odd.toml` prints, writes and ends well; the same input gives the same bytes;
    an existing folder is left alone.
    """
    (tmp_path / "odd.toml").write_text(ODD, encoding="utf-8")
    first = ran("odd.toml", "--poses", 8, cwd=tmp_path)
    assert first.returncode == 0, first.stderr
    assert "odd-sized/sized.toml\n" in first.stdout
    second = ran("odd.toml", "--poses", 8, "--out", "again", cwd=tmp_path)
    assert second.returncode == 0
    for name in ("result.json", "sized.toml"):
        assert (tmp_path / "again" / name).read_bytes() == (
            tmp_path / "odd-sized" / name
        ).read_bytes()
    third = ran("odd.toml", "--poses", 8, cwd=tmp_path)
    assert third.returncode == 2
    assert "exists" in third.stderr


@pytest.mark.usefixtures("few_scales", "unpainted")
def test_limits_that_no_section_meets_are_reported_with_numbers(tmp_path):
    """Where the largest tube exceeds a limit the command reports link, limit and value, writes no
    sized arm and exits with 1.
    """
    done = ran(
        Z_ARM,
        "--poses",
        8,
        "--family",
        "tube",
        "--outer",
        "20 mm .. 60 mm",
        "--wall",
        "3 mm",
        "--out",
        "weak",
        cwd=tmp_path,
    )
    assert done.returncode == 1
    assert "No allowed section meets the limits" in done.stderr
    assert "O: even tube 60 x 3 mm has a slope of" in done.stderr
    assert "times its limit of 0.5 arcmin" in done.stderr
    assert sorted(path.name for path in (tmp_path / "weak").iterdir()) == [
        "report.html",
        "result.json",
    ]
    said = json.loads((tmp_path / "weak" / "result.json").read_text(encoding="utf-8"))
    assert not said["holds"]
