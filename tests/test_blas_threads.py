"""No bit of a result depends on the number of threads that linear algebra is offered."""

from __future__ import annotations

import os
import subprocess
import sys
from pathlib import Path

import pytest

EXAMPLE = Path(__file__).parents[1] / "examples" / "gearbox" / "two-stage-lobes.toml"
# Every figure of the sheet, to the last bit.
ASKED = """
import sys, lostmotion
found = lostmotion.gear(sys.argv[1])
print([repr(getattr(each, "value", each)) for section in found.sheet.sections for row in section.rows for each in row.figures])
"""


@pytest.mark.slow
def test_the_number_of_threads_changes_no_bit():
    """From Python, where NumPy takes a thread per processor, as with one thread; without the limit the drawn gearbox differs."""
    found = []
    for threads in ("1", "2", "4"):
        environment = {key: value for key, value in os.environ.items() if not key.endswith("_NUM_THREADS")} | {"OPENBLAS_NUM_THREADS": threads}
        done = subprocess.run([sys.executable, "-c", ASKED, EXAMPLE], capture_output=True, text=True, check=True, env=environment)
        found.append(done.stdout)
    assert found[0].count("'") > 20
    assert found[1] == found[2] == found[0]
