"""Validity of first order in a closed chain near a parallel singularity: a five-bar towards its
straight distal links, beside the exact position of two circles.
"""

from pathlib import Path

import numpy as np
import pytest

import lostmotion
from lostmotion.error_model.pose_matrix import screws
from lostmotion.error_model.poses import Poses, sample_poses
from lostmotion.error_model.trust import (
    refuse_untrusted,
    trust,
    trust_remarks,
    trusted,
    with_figures,
)
from lostmotion.errors import InputError
from lostmotion.mechanism.assembly import assembled
from lostmotion.mechanism.closed_composition import composed
from lostmotion.mechanism.closed_trust import loosest, share_neglected
from lostmotion.mechanism.holding import spread_evenly
from lostmotion.mechanism.state import state_of
from lostmotion.propagation import factor_metrics
from lostmotion.propagation.iso9283 import cube
from tests.mechanism.closed_chains import at, five_bar

# A row of docs/validation.md each: quantity, compared with, agreement, other files.
VALIDATES = (
    (
        "share of the error that first order neglects near a parallel singularity of a five-bar",
        "exact intersection of two circles with the error in",
        "1e-4 of the error",
        "mechanism/closed_trust.py error_model/trust.py",
    ),
    (
        "share of the error that first order neglects in a hexapod with plays of 60 and 200 mm",
        "drawn robots solved exactly",
        "a factor of two",
        "mechanism/closed_trust.py error_model/trust.py",
    ),
)

FIVE_BAR = Path(__file__).parents[2] / "examples" / "closed-chains" / "five-bar.toml"
# Spread from the singularity (rad), first order and exact (µm), share neglected.
SPREADS = (
    (0.3, 21.375, 21.375, 0.0001),
    (0.03, 58.282, 58.252, 0.0006),
    (0.003, 182.735, 181.738, 0.0055),
    (0.0003, 577.401, 548.479, 0.0500),
)


def drives(spread):
    """Return the drives (2,) of a five-bar at this spread from its singularity, rad."""
    turned = np.arcsin(0.8) - spread
    return np.array([np.pi / 2 + turned, np.pi / 2 - turned])


def by_circles(q, shift):
    """Return the tip (2,) of the five-bar with its first elbow shifted along the distal link by
    `shift`, m: the intersection of two circles.
    """
    one, other = (
        np.array([x, 0]) + 0.25 * np.array([np.cos(a), np.sin(a)])
        for x, a in zip((0, 0.2), q, strict=True)
    )
    rods = 0.3 + shift, 0.3
    apart = other - one
    d = np.linalg.norm(apart)
    along = (d**2 + rods[0] ** 2 - rods[1] ** 2) / (2 * d)
    high = np.sqrt(rods[0] ** 2 - along**2)
    return one + apart / d * along + high * np.array([-apart[1], apart[0]]) / d


@pytest.mark.parametrize(("spread", "first", "exact", "share"), SPREADS)
def test_the_second_step_of_newton_is_what_first_order_neglects(spread, first, exact, share):
    """The share of a play of 20 µm grows as the exact position leaves first order."""
    q = drives(spread)
    state = at(five_bar(0.3), q)
    loops, place = state.closed[0], state.arm.places.index("e1")
    twist = np.array([0, 0, 0, 20e-6, 0, 0])
    linear = np.linalg.norm((state.carry(place)[0] @ twist)[3:])
    moved = np.linalg.norm(by_circles(q, 20e-6) - by_circles(q, 0.0))
    assert 1e6 * linear == pytest.approx(first, abs=6e-4)
    assert 1e6 * moved == pytest.approx(exact, abs=6e-3)
    found = share_neglected(loops, {place: twist[None]})[0]
    assert found == pytest.approx(share, abs=6e-5)
    assert found == pytest.approx(1 - moved / linear, abs=1e-4)


def test_the_loose_direction_of_a_five_bar_is_that_of_two_circles():
    """The tool twists most where differences of two circles have it, lengths counted as shares of
    the longest link; the gain in m/rad is the printed one.
    """
    q, longest, step = drives(0.3), 0.3, 1e-6
    (direction,), (gain,) = loosest(five_bar(0.3).tree, q[None])

    def twisted(drives):
        tip = by_circles(drives, 0.0)
        link = tip - 0.25 * np.array([np.cos(drives[0]), np.sin(drives[0])])
        return np.array([np.arctan2(link[1], link[0]), *tip / longest])

    columns = np.column_stack(
        [(twisted(q + step * each) - twisted(q - step * each)) / (2 * step) for each in np.eye(2)]
    )
    vectors, values, _ = np.linalg.svd(columns)
    assert np.linalg.norm(longest * columns[1:], ord=2) == pytest.approx(0.3107, abs=6e-5)
    assert gain == pytest.approx(values[0], rel=1e-6)
    assert abs(direction[2:5] @ vectors[:, 0]) == pytest.approx(1.0, rel=1e-9)


def test_poses_without_a_figure_are_refused_counted_and_explained(tmp_path):
    """Where first order fails at a pose, it has no figure: a pose that is given is refused, sampled
    ones are excluded, and the message names direction and part.
    """
    (tmp_path / "short.toml").write_text(FIVE_BAR.read_text().replace("400 mm", "300 mm"))
    arm = lostmotion.read(tmp_path / "short.toml")
    near = drives(1e-4)[None]
    assert trust(arm, near).neglected[0] > 0.1
    assert not trusted(arm, near)[0]
    with pytest.raises(InputError, match=r"first order neglects more than 10 %.*loose (along|in)"):
        lostmotion.study(arm, poses=near, robots=8, visits=2)
    home = np.array([arm.home])
    with pytest.raises(InputError, match="first order neglects more than 10 %"):
        lostmotion.study(arm, poses=np.repeat(home, 2, axis=0), method="analytic", at=near[0])
    mixed = Poses(np.concatenate([np.repeat(home, 31, axis=0), near]), "uniform", 2)
    assert len(with_figures(arm, mixed)) == 30
    wide = Poses(np.concatenate([np.repeat(home, 9, axis=0), near]), "uniform")
    with pytest.raises(InputError, match="1 of 10 poses"):
        with_figures(arm, wide)


def test_the_notes_count_poses_without_a_figure(tmp_path):
    """Lengths that vary by centimetres leave poses without a figure where the distal links are
    nearly straight: the notes of a study count them, and a study of many of them is refused.
    """
    text = FIVE_BAR.read_text().replace("400 mm ± 30 µm", "300 mm ± 8 mm")
    assert trust_remarks(lostmotion.read(FIVE_BAR)) == ()
    (tmp_path / "vague.toml").write_text(text)
    vague = lostmotion.read(tmp_path / "vague.toml")
    q = spread_evenly(vague.limits)
    found = trust(vague, q[assembled(vague, q)])
    count = np.count_nonzero(found.neglected > 0.1)
    assert count
    (note,) = trust_remarks(vague)
    assert note.startswith(f"at {count} of {len(found.neglected)} poses spread evenly first order")
    with pytest.raises(InputError, match="first order neglects"):
        refuse_untrusted(vague, q[assembled(vague, q)], (count - 1) / len(found.neglected))
    refuse_untrusted(vague, q[assembled(vague, q)], count / len(found.neglected))


def test_comparisons_targets_and_maps_exclude_poses_without_a_figure(tmp_path, monkeypatch):
    """Every question drops the sampled poses at which first order fails: arms that are compared
    pose by pose drop the same ones, allowances count the rest, and no cell of a map holds one. The
    notes of each sheet name them.
    """
    monkeypatch.setattr(factor_metrics, "_SAMPLES", 1 << 14)  # no size of a target is asked about
    text = FIVE_BAR.read_text().replace("400 mm ± 30 µm", "300 mm ± 4 mm")
    (tmp_path / "vague.toml").write_text(text)
    (tmp_path / "loose.toml").write_text(text.replace("8 µm ± 4 µm", "2 mm ± 8 µm"))
    vague, loose = (lostmotion.read(tmp_path / f"{name}.toml") for name in ("vague", "loose"))
    sampled = sample_poses(vague, 32)
    assert not trusted(vague, sampled.q).all()
    assert (trusted(vague, sampled.q) != trusted(loose, sampled.q)).any()
    compared = lostmotion.compare(vague, loose, poses=32, robots=2, visits=2)
    one, other = (each.poses.q for each in compared.arms)
    assert 0 < len(one) < len(sampled)
    assert np.array_equal(one, other)
    assert trusted(vague, one).all()
    assert trusted(loose, one).all()
    found = lostmotion.target(vague, error="20 mm", poses=32, robots=20, visits=2)
    assert 0 < len(found.poses) < len(sampled)
    assert trusted(vague, found.poses.q).all()
    shown = lostmotion.map(vague, poses=128, cell="80 mm")
    assert trusted(vague, shown.reached.q).all()
    for answer in (compared, found, shown):
        notes = " ".join(answer.sheet.notes)
        assert "poses spread evenly first order neglects more than 10 % of the error" in notes
    near = drives(1e-4)
    with pytest.raises(InputError, match="first order neglects more than 10 %"):
        lostmotion.compare(vague, loose, poses=near[None], robots=2, visits=2)


@pytest.fixture(scope="module")
def too_loose(tmp_path_factory):
    """Return the paths of a five-bar and a hexapod whose plays are too large for their shape."""
    folder = tmp_path_factory.mktemp("loose")
    texts = {
        "five-bar": ("8 µm ± 4 µm", "20 mm ± 4 mm"),
        "hexapod": ("3 µm ± 1 µm", "200 mm ± 1 mm"),
    }
    for name, (small, large) in texts.items():
        text = (FIVE_BAR.parent / f"{name}.toml").read_text(encoding="utf-8")
        (folder / f"{name}.toml").write_text(text.replace(small, large), encoding="utf-8")
    return folder


def test_a_hexapod_with_large_plays_errs_from_first_order_as_the_share_states(tmp_path):
    """Drawn robots whose ball joints have 60 mm of play, solved exactly, are off first order by half
    of the share that first order neglects to all of it; with 200 mm the same holds at home, and no
    robot assembles at a pose whose share is two thirds.
    """
    text = (FIVE_BAR.parent / "hexapod.toml").read_text(encoding="utf-8")
    neglected, off = {}, {}
    for play in (60, 200):
        (tmp_path / "loose.toml").write_text(text.replace("3 µm ± 1 µm", f"{play} mm ± 1 mm"))
        arm = lostmotion.read(tmp_path / "loose.toml")
        q = np.vstack([arm.home, sample_poses(arm, 64).q[::24]])
        neglected[play], off[play] = trust(arm, q).neglected, off_first_order(arm, q)
    ratio = np.concatenate([off[60] / neglected[60], off[200][:1] / neglected[200][:1]])
    assert ratio.min() > 0.5
    assert ratio.max() < 1.0
    assert max(neglected[60]) > 0.1 > min(neglected[60])
    assert neglected[200][1] > 0.6
    assert np.isnan(off[200][1])


def off_first_order(arm, q):
    """Return by how much robots differ from first order (pose,), relative to their errors in it;
    NaN where one does not assemble. Their draws are normal, cut at two standard deviations.
    """
    matrix = screws(state_of(arm, q))
    draws, rng = np.ones((20, len(matrix.infos))), np.random.default_rng(3)
    for columns in matrix.groups.values():
        if matrix.infos[columns[0]].draws:
            draws[:, columns] = np.clip(rng.standard_normal((20, 1)), -2, 2)
    first = np.einsum("pik,nk->pni", matrix.tool[:, 3:], draws)
    twists = {
        place: np.einsum("pik,nk->pni", matrix.local[:, :, own], draws[:, own])
        for place in np.unique(matrix.place).tolist()
        for own in [matrix.place == place]
    }
    state = matrix.state
    found = composed(state.closed[0], twists)[:, :, :3, 3] - state.frames[-1][:, None, :3, 3]
    apart, whole = (np.linalg.norm(each, axis=-1) for each in (found - first, first))
    return np.sqrt((apart**2).mean(axis=1) / (whole**2).mean(axis=1))


SLOWLY = ("iso9283", "compare", "target", "size for a target")
ASKED = {
    "study": ("five-bar", lambda path, _: lostmotion.study(path, poses=64)),
    "map": ("five-bar", lambda path, _: lostmotion.map(path)),
    "target": ("five-bar", lambda path, _: lostmotion.target(path, error="1 mm")),
    "size": ("five-bar", lambda path, _: lostmotion.size(path, slope="1 arcmin", poses=64)),
    "size for a target": ("five-bar", lambda path, _: lostmotion.size(path, target="1 mm")),
    "compare": ("five-bar", lambda path, _: lostmotion.compare(path, FIVE_BAR, poses=64)),
    "sweep": ("five-bar", lambda path, out: lostmotion.sweep(path, poses=64, out=out)),
    "iso9283": (
        "hexapod",
        lambda path, _: lostmotion.iso9283(
            path, cube="20 mm", centre=("0 mm", "0 mm", "500 mm"), robots=2, visits=2
        ),
    ),
    "task": (
        "five-bar",
        lambda path, _: lostmotion.task(
            path,
            by={
                "tool_rpy": ["0 deg", "0 deg", "0 deg"],
                "placement": {"xyz": ["100 mm", "480 mm", "0 mm"]},
                "features": [{"name": "end", "kind": "point", "at": ["0 mm", "0 mm", "0 mm"]}],
                "tolerances": [{"of": "end", "sphere": "1 mm"}],
            },
        ),
    ),
}


@pytest.mark.parametrize(
    "question",
    [pytest.param(each, marks=[pytest.mark.slow] * (each in SLOWLY)) for each in ASKED],
)
def test_plays_too_large_for_the_shape_of_a_chain_are_refused(
    question, too_loose, tmp_path, monkeypatch
):
    """Pins of 20 mm play turn a five-bar into another one: no question has a figure, and the
    remedy is a smaller play, not another pose.
    """
    # the poses among which the start for the cube of ISO 9283 is found, before it is refused
    monkeypatch.setattr(cube, "SAMPLES", 1024)
    name, ask = ASKED[question]
    with pytest.raises(InputError, match="first order neglects more than 10 %") as refused:
        ask(too_loose / f"{name}.toml", tmp_path / "run")
    (problem,) = refused.value.problems
    assert "and at home" in problem.found
    assert problem.expected.startswith("smaller errors, of ")
    assert ".bearing" in problem.expected
    assert not list(tmp_path.iterdir())


def test_poses_near_a_singularity_need_other_poses_and_not_smaller_plays(tmp_path):
    """Where the chain has figures at home, the message names the poses."""
    (tmp_path / "short.toml").write_text(FIVE_BAR.read_text().replace("400 mm", "300 mm"))
    with pytest.raises(InputError, match="farther from a parallel singularity") as refused:
        lostmotion.study(tmp_path / "short.toml", poses=drives(1e-4)[None])
    assert "at home" not in str(refused.value)
