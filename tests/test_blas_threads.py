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
found = lostmotion.gear(sys.argv[1], gearboxes=8)
print([repr(getattr(each, "value", each)) for section in found.sheet.sections for row in section.rows for each in row.cells])
"""
# Two calls that overlap and end in the order in which they began.
OVERLAPPING = """
import numpy, scipy.linalg
from contextlib import ExitStack
from threadpoolctl import threadpool_info
from lostmotion.blas_threads import one_blas_thread

def counts():
    return sorted({each["num_threads"] for each in threadpool_info() if each["user_api"] == "blas"})

before, first, second = counts(), ExitStack(), ExitStack()
first.enter_context(one_blas_thread())
second.enter_context(one_blas_thread())
first.close()
print(before, counts(), end=" ")
second.close()
print(counts())
"""


def printed(*words, threads):
    """Return what Python prints where NumPy may take so many threads."""
    environment = {
        key: value for key, value in os.environ.items() if not key.endswith("_NUM_THREADS")
    } | {"OPENBLAS_NUM_THREADS": threads}
    return subprocess.run(
        [sys.executable, "-c", *words], capture_output=True, text=True, check=True, env=environment
    ).stdout


@pytest.mark.slow
def test_the_number_of_threads_changes_no_bit():
    """From Python, where NumPy takes a thread per processor, as with one thread; without the limit
    the drawn gearbox differs.
    """
    # NumPy takes no more threads than there are processors
    threads = sorted({min(each, os.cpu_count()) for each in (1, 2, 4)})
    first, *others = (printed(ASKED, EXAMPLE, threads=str(each)) for each in threads)
    assert first.count("'") > 20
    assert others == [first] * (len(threads) - 1)


def test_calls_may_overlap():
    """Of two calls the first limits the threads, and the last to end lifts the limit."""
    # one where the machine has one processor
    assert printed(OVERLAPPING, threads="2") in {"[2] [1] [2]\n", "[1] [1] [1]\n"}
