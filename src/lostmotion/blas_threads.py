"""One thread for linear algebra: with the number of threads the last bits of a result would
change.
"""

from __future__ import annotations

import os
import threading
from contextlib import contextmanager
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from collections.abc import Iterator


class _Limited:
    """How many calls are under way, and what limits the threads meanwhile: it concerns the whole
    process.
    """

    lock = threading.Lock()
    calls = 0
    limits: Any = None


@contextmanager
def one_blas_thread() -> Iterator[None]:
    """Let the products and solutions of NumPy and SciPy take one thread. The matrices here are too
    small to gain from more.

    Calls in several threads may overlap: the first limits, the last one lifts the limit.
    """
    with _Limited.lock:
        if not _Limited.calls:
            _Limited.limits = _limits()
        _Limited.calls += 1
    try:
        yield
    finally:
        with _Limited.lock:
            _Limited.calls -= 1
            if not _Limited.calls and _Limited.limits is not None:
                _Limited.limits.restore_original_limits()


def _limits() -> Any:  # noqa: ANN401 - threadpoolctl publishes no types
    """Limit the libraries to one thread; None where they have no more, as on the command line,
    which says so before they are loaded.
    """
    from threadpoolctl import threadpool_info, threadpool_limits

    if os.environ.get("OPENBLAS_NUM_THREADS") == "1" and all(
        each["num_threads"] == 1 for each in threadpool_info() if each["user_api"] == "blas"
    ):
        return None
    import scipy.linalg  # noqa: F401 - its BLAS is a library of its own, which is limited only once it is loaded

    return threadpool_limits(1, user_api="blas")
