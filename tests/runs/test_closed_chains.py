"""Sweeps, replays and sizing of a closed chain."""

from pathlib import Path

import pytest

import lostmotion
from lostmotion.errors import InputError

FIVE_BAR = Path(__file__).parents[2] / "examples" / "closed-chains" / "five-bar.toml"


@pytest.fixture(scope="module")
def swept(tmp_path_factory):
    """Return a sweep of two lengths of a link of a five-bar, and its folder."""
    folder = tmp_path_factory.mktemp("swept") / "run"
    by = {"joints.left.link.length": ["250 mm ± 30 µm", "240 mm ± 30 µm"]}
    return lostmotion.sweep(FIVE_BAR, by=by, poses=16, robots=8, visits=2, out=folder), folder


def test_a_design_of_a_sweep_of_a_closed_chain_has_the_errors_of_its_study(swept):
    """The design as stated has the mean and the r.m.s. error that a study of the same poses and
    robots has.
    """
    study = lostmotion.study(FIVE_BAR, poses=16, robots=8, visits=2)
    for key in ("mean", "rms"):
        of_design = swept[0].outcomes[0].figures[key].value
        assert of_design == pytest.approx(study.figures[key].value, rel=1e-9)


def test_the_largest_error_of_a_closed_chain_is_replayed(swept):
    """The largest error is the sum of its terms, and the exact position of the chain with these
    errors put in, by Newton's method on its closures, differs by less than 1 % of it.
    """
    (replayed,) = lostmotion.replay(swept[1])
    assert replayed.reproduced
    exactly = replayed.exact[:3, 3] - replayed.tool[:3, 3]
    assert exactly == pytest.approx(replayed.error, abs=0.01 * replayed.length)


def test_a_sweep_refuses_poses_that_a_study_would_exclude(tmp_path):
    """Limits that reach beside a singularity are refused before anything is written."""
    wide = FIVE_BAR.read_text().replace('["100 deg", "160 deg"]', '["10 deg", "160 deg"]')
    (tmp_path / "wide.toml").write_text(
        wide.replace('["20 deg", "80 deg"]', '["20 deg", "170 deg"]')
    )
    with pytest.raises(InputError, match="of 64 poses between the limits"):
        lostmotion.sweep(tmp_path / "wide.toml", poses=64, robots=2, visits=2, out=tmp_path / "run")
    assert not (tmp_path / "run").exists()


def test_a_sweep_refuses_poses_at_which_first_order_fails(tmp_path):
    """Poses between the limits of the drives where rods of uncertain length are nearly in line, and
    the same ones from a file.
    """
    near = FIVE_BAR.read_text().replace('["100 deg", "160 deg"]', '["146 deg", "148 deg"]')
    near = near.replace('["20 deg", "80 deg"]', '["43 deg", "45 deg"]')
    near = near.replace('start = "130 deg"', 'start = "147 deg"')
    near = near.replace('start = "50 deg"', 'start = "44 deg"')
    near = near.replace("400 mm ± 30 µm", "300 mm ± 8 mm")
    (tmp_path / "near.toml").write_text(near)
    (tmp_path / "poses.csv").write_text("left [deg],right [deg]\n147,44\n")
    for poses in (64, tmp_path / "poses.csv"):
        with pytest.raises(InputError, match="first order neglects more than 10 % of the error"):
            lostmotion.sweep(
                tmp_path / "near.toml", poses=poses, robots=2, visits=2, out=tmp_path / "run"
            )
        assert not (tmp_path / "run").exists()


@pytest.mark.slow
def test_links_of_a_closed_chain_are_sized():
    """Lighter sections meet the limit on the slope of links, and a tighter limit needs more mass."""
    loose, tight = (
        lostmotion.size(FIVE_BAR, slope=slope, poses=64) for slope in ("1 arcmin", "0.5 arcmin")
    )
    assert loose.sized.mass < tight.sized.mass
