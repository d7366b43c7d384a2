"""The wording of sheets against the texts that `python -m tests.reporting.snapshots` writes."""

import pytest

from tests.reporting.snapshots import FOLDER, SHEETS, wording


@pytest.mark.usual_counts  # as in the command
@pytest.mark.parametrize("name", SHEETS)
def test_a_sheet_reads_as_its_snapshot(name):
    """Every word of a sheet is as reviewed; after a deliberate change run
    `python -m tests.reporting.snapshots` and read the difference.
    """
    kept = (FOLDER / f"{name}.txt").read_text(encoding="utf-8")
    assert wording(SHEETS[name]()) == kept, f"python -m tests.reporting.snapshots {name}"


def test_every_snapshot_belongs_to_a_sheet():
    """No text stays behind when its sheet goes."""
    assert {path.stem for path in FOLDER.iterdir()} == set(SHEETS)
