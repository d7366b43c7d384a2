"""Spoiled files of all formats: each is refused in words or gives finite figures. `python -m
tests.io.fuzzed` spoils as many as one likes.
"""

from __future__ import annotations

import warnings
from collections import Counter

import pytest

from lostmotion import read
from lostmotion.accuracy import workspace
from lostmotion.analyses.result import Result
from lostmotion.errors import InputError
from tests.io.consistent import studied_shortly
from tests.io.fuzzed import longest, outcomes
from tests.io.fuzzed_formats import EXAMPLES, formats

pytestmark = [pytest.mark.few_counts, pytest.mark.usefixtures("few_samples")]


def look_at(folder, count):
    """Spoil and read so many files: none may be wrong or slow, and of each format some must be read
    and some refused.
    """
    counts = Counter()
    for found in outcomes(folder, 0, count):
        assert not found.said.startswith("wrong"), (
            f"{found.format}, number {found.number}: {found.said}\n{found.raw[:2000]!r}"
        )
        assert found.seconds < longest(found), (
            f"{found.format}, number {found.number}: {found.seconds:.0f} s"
        )
        counts[found.format, found.said] += 1
    return counts


def test_the_files_that_are_spoiled_are_sound_before(tmp_path, monkeypatch):
    """Every text that the spoiling begins with is read: else it would be refused for what nobody
    spoiled. What has a study is read in the next test.
    """
    # most of what a sound command takes, and refuses nothing
    monkeypatch.setattr(workspace, "SAMPLES", 4096)
    monkeypatch.setattr(Result, "report", lambda *_, **__: tmp_path / "made")
    for kind in (kind for kind in formats(tmp_path) if kind.study is None):
        for seed in kind.seeds:
            path = tmp_path / kind.name
            path.write_text(seed, encoding="utf-8")
            kind.read(path)


WRIST = """limits = ["-95 deg", "95 deg"]
gearbox = { backlash = \""""


@pytest.mark.parametrize(
    ("old", "new", "said"),
    [
        ('length = "135 mm"', 'length = "1e16 mm"', "no stable equilibrium"),
        (f"{WRIST}1 deg", f"{WRIST}1e15 deg", "no stable equilibrium"),
        ('backlash = "1 deg ± 0.3 deg"', 'backlash = "1e9 deg ± 0.3 deg"', "errors of 16 m"),
    ],
)
def test_sizes_that_no_arm_has_are_refused_in_words(tmp_path, old, new, said):
    """A unit that is wrong by many powers of ten overflows in no sum, solves no singular matrix."""
    text = (EXAMPLES / "printed-hobby-arm.toml").read_text("utf-8")
    path = tmp_path / "arm.toml"
    assert old in text
    path.write_text(text.replace(old, new, 1), "utf-8")
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        with pytest.raises(InputError, match=said):
            studied_shortly(read(path))


@pytest.mark.slow
def test_what_is_described_before_spoiling_is_studied(tmp_path):
    """Every text that the spoiling begins with is read, and has a small study with finite figures,
    or lacks any source of error.
    """
    for kind in (kind for kind in formats(tmp_path) if kind.study is not None):
        for seed in kind.seeds:
            path = tmp_path / kind.name
            path.write_text(seed, encoding="utf-8")
            kind.read(path)
            try:
                kind.study(path)
            except InputError as error:
                assert "no error source is described" in str(error), seed  # noqa: PT017 - one of the texts has none


@pytest.mark.slow
def test_two_thousand_spoiled_files_are_refused_or_read(tmp_path):
    """Whatever is done to a file of any format: a refusal in words or finite figures, no traceback,
    warning or control character, nothing written.
    """
    counts = look_at(tmp_path, 2_000)
    rare: Counter[str] = Counter()
    for kind in formats(tmp_path):
        outcome = {
            "readable": counts[kind.name, "read"] + counts[kind.name, "studied"],
            "refused": counts[kind.name, "refused"],
        }
        if kind.every == 1:
            assert min(outcome.values()) > 5, (kind.name, counts)
        else:  # of each of these a dozen: counted together
            rare.update(outcome)
    assert min(rare["readable"], rare["refused"]) > 0, counts


@pytest.mark.parametrize("text", ["\x1f3", "3\u2028", "\u0663", "\x1f\n3"])
def test_a_pose_number_of_other_characters_is_refused(tmp_path, text):
    """Separators that no keyboard has, and digits of other scripts, are one mistake."""
    place = next(kind for kind in formats(tmp_path) if kind.name == "place.txt")
    (tmp_path / place.name).write_bytes(text.encode("utf-8"))
    with pytest.raises(InputError):
        place.read(tmp_path / place.name)
