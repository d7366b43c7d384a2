"""Arms that the study's tests share."""

import gc
import os
from collections.abc import Iterator
from pathlib import Path
from types import ModuleType
from typing import Final

import pytest

# Before NumPy is loaded: the suite runs on all processors already, and threads of dense algebra
# inside each worker only wait for each other.
os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")

from lostmotion import Arm, Study, study
from lostmotion.accuracy import workspace
from lostmotion.analyses.sizing import command as sizing_command
from lostmotion.analyses.sizing import selection, sizing
from lostmotion.error_model import few_poses
from lostmotion.maps import validation_points
from lostmotion.parts.gearbox.cycloidal import examined, model
from lostmotion.propagation import exact, factor_metrics
from lostmotion.propagation.montecarlo import bands
from lostmotion.reporting import svg
from tests.arms import arm_of

# Counts that each answer of a study takes, whatever is asked for, and what a test computes with in
# their place: most tests are of other answers, whose time these would be. As in the product they
# are in tests marked `usual_counts`, in slow tests unless marked `few_counts`, and in commands of
# their own process.
COUNTS: Final[tuple[tuple[ModuleType, str, int], ...]] = (
    (workspace, "SAMPLES", 1 << 15),  # tool positions, of 524 288
    (few_poses, "MANY", 128),  # poses with which few are compared, of 2 048
    (bands, "DRAWS", 8),  # of values known to a range, of 32
    (exact, "ROBOTS", 4),  # composed exactly at each pose of the check, of 16
    (exact, "VISITS", 2),  # of each, of 4
    (model, "GEARBOXES", 64),  # behind a table of cycloidal gearboxes, of 256
    (model, "_HARMONIC_GEARBOXES", 4),  # behind their spectrum, of 48
    (examined, "MOST_SPECTRA", 8),  # whose transmission error is shown, of 64
    (validation_points, "SAMPLED", 4096),  # poses by which points of a map are reached, of 32 768
    (validation_points, "_POWER", 9),  # of two, in number, at which a map is validated, of 11
)
USUAL: Final = tuple(getattr(module, name) for module, name, _ in COUNTS)


@pytest.hookimpl(tryfirst=True)
def pytest_runtest_setup(item: pytest.Item) -> None:
    """Set the counts of a test before its fixtures."""
    marked = {marker.name for marker in item.iter_markers()}
    usual = "usual_counts" in marked or ("slow" in marked and "few_counts" not in marked)
    wanted = USUAL if usual else tuple(few for _, _, few in COUNTS)
    if wanted != tuple(getattr(module, name) for module, name, _ in COUNTS):
        for (module, name, _), count in zip(COUNTS, wanted, strict=True):
            setattr(module, name, count)
        model._behaviour.cache_clear()  # tables from other numbers of gearboxes


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
def unpainted(monkeypatch: pytest.MonkeyPatch) -> None:
    """Leave the plots of reports empty, where a test reads nothing of them: each has its place on
    the page all the same, and is not written as SVG.
    """
    monkeypatch.setattr(svg, "raw_svg", lambda _: '<svg viewBox="0 0 1 1"></svg>')


@pytest.fixture(scope="module")
def few_samples() -> Iterator[None]:
    """Allocate a target by 16 thousand samples in place of 262 thousand, and study selected parts
    with 64 poses, 32 robots and 3 visits, and compute trade-offs at two limits or at two targets
    besides the stated one: for files of tests of words, keys and files, not of figures.
    """
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(factor_metrics, "_SAMPLES", 1 << 14)
        patch.setattr(sizing_command, "DEFAULT_POSES", 64)
        patch.setattr(sizing_command, "DEFAULT_ROBOTS", 32)
        patch.setattr(sizing_command, "DEFAULT_VISITS", 3)
        patch.setattr(sizing, "SCALES", (1.0, 2.0))
        patch.setattr(selection, "SCALES", (0.9, 1.1))
        yield
