"""Arms that the study's tests share."""

import gc
import os
from pathlib import Path

import pytest

# Before NumPy is loaded: the suite runs on all processors already, and threads of dense algebra
# inside each worker only wait for each other.
os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")

from lostmotion import Arm, Study, study
from lostmotion.error_model import few_poses
from lostmotion.parts.gearbox.cycloidal import examined, model
from tests.arms import arm_of


def pytest_configure() -> None:
    """Collect garbage less often than Python's 700 new objects: it would search the millions that
    live to the end again and again, for a tenth of the suite's time.
    """
    gc.set_threshold(100_000, 10, 10)


def pytest_collection_finish() -> None:
    """Search no more what was collected: it lives to the end of the suite."""
    gc.freeze()


@pytest.fixture(scope="session")
def arm() -> Arm:
    """Return an arm with every kind of error."""
    return arm_of()


@pytest.fixture(scope="session")
def z_arm_study() -> Study:
    """Return the study of the Z-arm by both methods, of which nothing is changed."""
    return study(Path(__file__).parents[1] / "examples" / "z-arm.toml", 64, 60, 3, method="both")


@pytest.fixture
def few_compared_poses(monkeypatch):
    """Compare the poses of a study with 128 more in place of 2 048, by which it finds that they are
    too few: for tests of other answers, whose time these 2 048 would be.
    """
    monkeypatch.setattr(few_poses, "MANY", 128)


@pytest.fixture(scope="module")
def few_gearboxes():
    """Compute tables of cycloidal gearboxes from 64 of them and spectra from 4, in place of 256 and
    48, and show the transmission error of at most 8 in place of 64: for files of tests that compare
    no statistics of these.
    """
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(model, "GEARBOXES", 64)
        patch.setattr(model, "_HARMONIC_GEARBOXES", 4)
        patch.setattr(examined, "MOST_SPECTRA", 8)
        model._behaviour.cache_clear()
        yield
    model._behaviour.cache_clear()
