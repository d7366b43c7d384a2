"""What a study computes once although several of its figures need it."""

from pathlib import Path

import lostmotion
from lostmotion.error_model import pose_matrix
from lostmotion.mechanism import standing
from lostmotion.recent import Recent

EXAMPLES = Path(__file__).parents[2] / "examples"


def test_a_study_settles_the_arm_once_at_each_pose(monkeypatch):
    """Samples, budget, remedies and bending of links need the same states and pose matrices at the
    2 048 poses of a study: each is computed once, in blocks of as many poses for all of them.
    """
    settled, formed = [], []
    for module, name, seen in ((standing, "_RECENT", settled), (pose_matrix, "_RECENT", formed)):
        kept = getattr(module, name)

        class Counted(Recent):
            def of(self, key, compute, seen=seen):
                return super().of(key, lambda: seen.append(key[1:]) or compute())

        monkeypatch.setattr(module, name, Counted(kept._most, kept._size))
    lostmotion.study(EXAMPLES / "z-arm.toml", robots=100, visits=3)
    assert len(settled) == len(set(settled))
    assert len(formed) == len(set(formed))
    assert sum(len(key[0]) for key in settled) == (2048 + 512) * 5 * 8
