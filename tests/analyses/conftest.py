"""Small counts for tests of what a sheet says."""

import pytest

from lostmotion.analyses.sizing import command, selection, sizing
from lostmotion.propagation import factor_metrics


@pytest.fixture(scope="module")
def few_samples():
    """Allocate a target by 16 thousand samples in place of 262 thousand, and study selected parts
    with 64 poses, 32 robots and 3 visits, and compute trade-offs at two limits or at two targets
    besides the stated one: for files of tests of words, keys and files, not of figures.
    """
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(factor_metrics, "_SAMPLES", 1 << 14)
        patch.setattr(command, "DEFAULT_POSES", 64)
        patch.setattr(command, "DEFAULT_ROBOTS", 32)
        patch.setattr(command, "DEFAULT_VISITS", 3)
        patch.setattr(sizing, "SCALES", (1.0, 2.0))
        patch.setattr(selection, "SCALES", (0.9, 1.1))
        yield
