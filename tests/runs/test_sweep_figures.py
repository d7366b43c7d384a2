"""Mass, price and repeatability of the designs of a sweep, and a run that takes the place of
another.
"""

from __future__ import annotations

import json

import pytest

import lostmotion
from lostmotion.errors import OutputExistsError
from tests.command import carried_out as command

ARM = """
name = "priced"
payload = { mass = "2 kg" }
[gearboxes.small]
ratio = 50
stiffness = "10 N m/arcmin"
backlash = "1 arcmin ± 0.3 arcmin"
mass = "2 kg"
price = 300
[gearboxes.big]
ratio = 50
stiffness = "20 N m/arcmin"
backlash = "0.5 arcmin ± 0.1 arcmin"
mass = "4 kg"
price = 700
[[joints]]
name = "A"
type = "revolute"
axis = "z"
limits = ["-90 deg", "90 deg"]
gearbox = "small"
link = { length = "300 mm ± 50 µm", rigid = true, mass = "1 kg" }
[[joints]]
name = "B"
type = "revolute"
axis = "y"
limits = ["-60 deg", "60 deg"]
gearbox = "small"
link = { length = "200 mm ± 50 µm", rigid = true, mass = "1 kg" }
[sweep]
"joints.A.gearbox" = ["small", "big"]
"joints.B.gearbox" = ["small", "big"]
"""
SMALL = {"poses": 32, "robots": 40, "visits": 4, "workers": 1}


@pytest.fixture
def arm(tmp_path):
    """Return the path of an arm whose two gearboxes are swept over two kinds with mass and
    price.
    """
    path = tmp_path / "priced.toml"
    path.write_text(ARM, encoding="utf-8")
    return path


def test_a_sweep_states_mass_price_and_repeatability_of_each_design(arm, tmp_path):
    """Mass and price are sums over the parts; cards name the designs with the smallest RP, mass and
    price, and every surface has the figures.
    """
    found = lostmotion.sweep(arm, out=tmp_path / "run", **SMALL)
    (masses,) = (section for section in found.sheet.sections if section.key == "masses")
    assert [[figure.value for figure in row.cells] for row in masses.rows] == [
        [6, 600],
        [8, 1000],
        [8, 1000],
        [10, 1400],
    ]
    cards = {card.title: (card.number, card.quiet) for card in found.sheet.cards}
    assert cards["mass, lightest design"] == ("6.00 kg", "A gearbox small, B gearbox small")
    assert cards["price, cheapest design"] == ("600", "A gearbox small, B gearbox small")
    assert cards["RP, any approach, best design"][1].startswith("A gearbox big, ")
    arrays = found.arrays()
    assert arrays["price"].values.tolist() == [[600, 1000], [1000, 1400]]
    assert arrays["mass"].values.tolist() == [[6, 8], [8, 10]]
    # What B carries closes its backlash: it does not repeat better with the other gearbox, but
    # droops less, and so changes A's lever. At most 5 N m wind it up by 0.25 arcmin less, and play
    # by 0.25 arcmin less: 1.5e-4 rad times 0.2 m sin 60° of at least 0.3 + 0.2 cos 60° m.
    repeats = arrays["rp_any_p95"].values[..., 0]
    assert repeats[:, 0] == pytest.approx(repeats[:, 1], rel=6.5e-5)
    assert repeats[1, 0] < 0.6 * repeats[0, 0]
    assert [each["price"] for each in found.result()["designs"]] == [600, 1000, 1000, 1400]
    assert [plot.section for plot in found.plots].count("masses") == 1
    assert "prices" not in found.sheet.facts["not_counted"]


def test_a_price_that_is_not_stated_is_no_price(arm, tmp_path):
    """A design with a gearbox without a price is not the cheapest: its joint is named, and without
    any price there is no column.
    """
    arm.write_text(ARM.replace("price = 300\n", ""), encoding="utf-8")
    found = lostmotion.sweep(arm, out=tmp_path / "run", **SMALL)
    (masses,) = (section for section in found.sheet.sections if section.key == "masses")
    assert [str(row.cells[1]) for row in masses.rows] == ["not stated", "700", "700", "1400"]
    assert [row.note for row in masses.rows] == [
        "no price of A, B",
        "no price of A",
        "no price of B",
        "",
    ]
    assert "price, cheapest design" not in {card.title for card in found.sheet.cards}
    arm.write_text(ARM.replace("price = 300\n", "").replace("price = 700\n", ""), encoding="utf-8")
    without = lostmotion.sweep(arm, out=tmp_path / "other", **SMALL)
    (masses,) = (section for section in without.sheet.sections if section.key == "masses")
    assert masses.columns == ("mass",)
    assert "price" not in without.arrays()
    assert "prices (none is stated)" in without.sheet.facts["not_counted"]


@pytest.mark.usefixtures("unpainted")
def test_force_replaces_another_run_and_continues_the_same(arm, tmp_path):
    """Without it another number of robots is refused and nothing is touched; with it the folder is
    that of a run from the start, to the last byte.
    """
    arm.write_text(ARM.replace('"joints.B.gearbox" = ["small", "big"]\n', ""), encoding="utf-8")
    out = tmp_path / "run"
    lostmotion.sweep(arm, out=out, **SMALL).report()
    before = (out / "result.json").read_bytes()
    with pytest.raises(OutputExistsError, match="--force"):
        lostmotion.sweep(arm, out=out, **{**SMALL, "robots": 50})
    assert (out / "result.json").read_bytes() == before
    for folder in (out, tmp_path / "fresh"):
        lostmotion.sweep(arm, out=folder, force=True, **{**SMALL, "robots": 50}).report()
    files = {path.relative_to(out): path.read_bytes() for path in out.rglob("*") if path.is_file()}
    assert files == {
        path.relative_to(tmp_path / "fresh"): path.read_bytes()
        for path in (tmp_path / "fresh").rglob("*")
        if path.is_file()
    }
    ledger = {path: path.stat().st_mtime_ns for path in (out / "ledger").iterdir()}
    lostmotion.sweep(arm, out=out, force=True, **{**SMALL, "robots": 50})
    assert {path: path.stat().st_mtime_ns for path in (out / "ledger").iterdir()} == ledger


def test_force_leaves_files_that_no_run_wrote(arm, tmp_path):
    """A stranger's file, a folder without a run and a run.json that is none are left alone, with
    exit code 2.
    """
    words = ("sweep", arm, "--poses", "32", "--visits", "4", "--force", "--out")
    run, folder, torn = (tmp_path / name for name in ("run", "folder", "torn"))
    lostmotion.sweep(arm, out=run, **SMALL)
    for each in (folder, torn):
        each.mkdir()
    (torn / "run.json").write_text("{}", encoding="utf-8")
    for each in (run, folder, torn):
        (each / "mine.txt").write_text("mine", encoding="utf-8")
    for each in (run, folder, torn):
        before = sorted(each.rglob("*"))
        done = command(*words, each, "--robots", "50", cwd=tmp_path)
        assert done.returncode == 2, done.stderr
        assert sorted(each.rglob("*")) == before
    assert json.loads((run / "run.json").read_bytes())["robots"] == 40
