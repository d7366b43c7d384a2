"""A study of a pose and a zone, with a requested precision: what it prints, writes and refuses."""

import json
from pathlib import Path

import pytest

import lostmotion
from lostmotion import Arm
from lostmotion.error_model.remedies import EVERY_STAGE
from lostmotion.propagation.montecarlo import sensitivity
from tests.command import carried_out

ARM = Path(__file__).parents[3] / "examples" / "scara.toml"
QUICK = ("--poses", "32", "--robots", "40", "--visits", "3")
AT = "shoulder=10deg elbow=-30deg lift=50mm turn=5deg"


def run(*words, cwd, arm=ARM):
    """Run the command in a folder."""
    return carried_out("run", arm, *QUICK, *words, cwd=cwd)


@pytest.mark.usefixtures("unpainted")
def test_poses_zones_and_the_stopping_rule_are_in_the_report(tmp_path):
    """Each place has its two tables, shares add to 100 %, the verdict says what was reached, and
    every stage of the remedies has its intervals.
    """
    done = run(
        "--at",
        AT,
        "--at",
        "3",
        "--zone",
        "z 0..2 m",
        "--until",
        "40 %",
        "--out",
        "out",
        cwd=tmp_path,
    )
    assert done.returncode == 0, done.stderr
    assert (
        "Reached ±40 % over the workspace (mean, 95th percentile, AP, RP, any approach) after"
        in " ".join(done.stdout.split())
    )
    assert (
        "Reached ±40 % in the zone z 0 … 2000 mm (mean, 95th percentile, AP, RP, any "
        "approach) after"
    ) in " ".join(done.stdout.split())
    sections = {
        section["key"]: section
        for section in json.loads((tmp_path / "out" / "result.json").read_text())["sections"]
    }
    assert {f"{what}_at_{k}" for what in ("budget", "causes") for k in (1, 2, 3)} <= set(sections)
    assert "shoulder 10.0°" in sections["budget_at_1"]["title"]
    assert "pose 3" in sections["budget_at_2"]["title"]
    assert "z 0 … 2000 mm" in sections["budget_at_3"]["title"]
    for k in (1, 2, 3):
        rows = sections[f"budget_at_{k}"]["rows"]
        shares = [row["figures"][1]["value"] for row in rows]
        assert sum(shares[:-1]) == pytest.approx(1, abs=1e-11)
        assert rows[-1]["label"] == "all together"
    stages = sections["waterfall"]["rows"]
    assert [row["label"] for row in stages] == list(EVERY_STAGE)
    assert all(figure["interval"] for row in stages for figure in row["figures"] if figure["value"])
    page = (tmp_path / "out" / "report.html").read_text()
    assert 'id="plot-waterfall"' in page
    assert 'id="plot-budget-at-3"' in page


@pytest.mark.usefixtures("unpainted")
def test_the_error_budget_is_reported_without_sampling_too(tmp_path):
    """The same levels, parts and kinds of error over the workspace, at a pose and in a zone as by
    samples, since none of it was sampled.
    """
    told = {}
    for method, out in (("analytic", ("--out", "out")), ("montecarlo", ("--json",))):
        # what is compared is summed over terms, whatever the number of robots
        few = ("--poses", "16", "--robots", "8", "--visits", "2")
        words = ("--at", "3", "--zone", "z 0..2 m", "--method", method, *few, *out)
        done = run(*words, cwd=tmp_path, arm=ARM.with_name("planar-2r.toml"))
        assert done.returncode == 0, done.stderr
        written = tmp_path / "out" / "result.json"
        text = done.stdout if "--json" in out else written.read_text()
        assert "largest contributor: " in text
        sections = json.loads(text)["sections"]
        told[method] = {
            section["key"]: [(row["label"], row["figures"]) for row in section["rows"]]
            for section in sections
        }
    places = {f"{what}_at_{k}" for what in ("budget", "causes") for k in (1, 2)}
    for key in {"levels", "budget_levels", "causes_levels"} | places:
        assert len(told["analytic"][key]) > 2
        by_samples = dict(told["montecarlo"][key])
        for label, figures in told["analytic"][key]:
            assert [figure["value"] for figure in figures] == [
                figure["value"] for figure in by_samples[label]
            ], (key, label)
    page = (tmp_path / "out" / "report.html").read_text()
    assert "largest contributor: " in page
    assert all(
        f'id="plot-{plot}"' in page
        for plot in ("levels", "budget", "causes", "budget-at-1", "budget-at-2")
    )


@pytest.mark.parametrize(
    ("words", "named"),
    [
        (("--at", "32"), "from 0 to 31"),
        (("--zone", "x 5..6 m"), "none of the 524288 poses"),
        (("--until", "soon"), "until"),
        (("--at", "32", "--method", "analytic"), "from 0 to 31"),
    ],
)
def test_what_cannot_be_answered_is_refused_before_the_work(tmp_path, words, named):
    """One message, exit code 2, and no folder."""
    done = run(*words, cwd=tmp_path)
    assert done.returncode == 2
    assert named in done.stderr
    assert not list(tmp_path.iterdir())


@pytest.mark.parametrize("method", ["analytic", "montecarlo"])
def test_what_errs_by_nothing_has_no_empty_tables(method):
    """An arm stated to be rigid has no part to halve: neither over the workspace nor at a pose is
    there a table without a row.
    """
    joint = {
        "name": "A",
        "type": "revolute",
        "axis": "z",
        "limits": (-1, 1),
        "link": {"length": "300 mm", "rigid": True},
    }
    study = lostmotion.study(
        Arm.model_validate({"name": "ideal", "joints": [joint]}),
        16,
        robots=8,
        visits=2,
        method=method,
    ).with_budget(at=3)
    assert [section.key for section in study.sheet.sections if not section.rows] == []
    assert not any(section.key.startswith("halving") for section in study.sheet.sections)


def test_one_visit_says_why_there_is_no_repeatability():
    """With one visit the sheet keeps its place for ISO 9283 and says what it needs."""
    sections = {
        section.key: section
        for section in lostmotion.study(lostmotion.read(ARM), 16, robots=8, visits=1).sheet.sections
    }
    assert sections["iso9283"].note == "needs at least 2 visits"


@pytest.mark.parametrize("method", ["analytic", "montecarlo"])
def test_questions_still_to_come_keep_to_the_study_s_threads(monkeypatch, method):
    """A study on one thread answers the next question on one thread too."""
    used = []
    kept = sensitivity.halving_at
    monkeypatch.setattr(
        sensitivity,
        "halving_at",
        lambda *given, threads, **named: (
            used.append(threads) or kept(*given, threads=threads, **named)
        ),
    )
    arm = lostmotion.read(ARM.with_name("planar-2r.toml"))
    study = lostmotion.study(arm, 8, robots=8, visits=2, method=method, threads=1)
    _ = study.with_budget(at=3).halving
    assert used == [1] * (2 if method == "analytic" else 1)
