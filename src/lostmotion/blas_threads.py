"""One thread for linear algebra: with the number of threads the last bits of a result would change."""

from __future__ import annotations

import contextlib
import os
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from contextlib import AbstractContextManager


def one_blas_thread() -> AbstractContextManager[object]:
    """Return a context in which the products and solutions of NumPy and SciPy take one thread. The matrices here are too small to gain from more."""
    if os.environ.get("OPENBLAS_NUM_THREADS") == "1":  # as on the command line: set before NumPy was loaded
        return contextlib.nullcontext()
    import scipy.linalg  # noqa: F401 - its BLAS is a library of its own, which is limited only once it is loaded
    from threadpoolctl import threadpool_limits

    limits: AbstractContextManager[object] = threadpool_limits(1, user_api="blas")
    return limits
