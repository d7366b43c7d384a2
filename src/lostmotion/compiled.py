"""How kernels are compiled: cached, without the interpreter's lock, and without fast mathematics,
so that every sum runs in its written order.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, Any, Final, Protocol, cast

import numpy as np
from numba import njit

from lostmotion.compile_cache import KernelCache, base_folder

if TYPE_CHECKING:
    from collections.abc import Callable

_OPTIONS: Final[dict[str, Any]] = {"nogil": True, "error_model": "numpy", "boundscheck": False}
base_folder()  # before other processes start: they inherit a temporary folder


class Kernel(Protocol):
    """A compiled function. `py_func` is the function that it was compiled from."""

    py_func: Callable[..., Any]

    def __call__(self, *arguments: Any) -> Any:  # noqa: ANN401 - Numba infers the types
        """Return what the function returns."""


def compiled_with(**options: Any) -> Callable[[Callable[..., Any]], Kernel]:  # noqa: ANN401 - options of Numba
    """Return a decorator that compiles a kernel with further options of Numba, `fastmath` for
    one.
    """
    options = _OPTIONS | options

    def compile_later(function: Callable[..., Any]) -> Kernel:
        dispatcher: Any = njit(**options)(function)
        # It is the function itself with NUMBA_DISABLE_JIT. Functions of others do not belong to the
        # source that the cache's key covers.
        if dispatcher is not function and function.__module__.startswith("lostmotion."):
            dispatcher._cache = KernelCache(function)  # noqa: SLF001 - where Numba's own `enable_caching` puts its cache
        return cast("Kernel", dispatcher)

    return compile_later


compiled = compiled_with()
# With products and sums fused into one rounding, a kernel and the functions that it calls.
fused = compiled_with(fastmath={"contract"})
# A called function that stayed one of its own would be compiled twice and fused in two ways: by
# itself, and within the kernel. Which of them runs would depend on whether the kernel comes from
# the cache.
fused_part = compiled_with(fastmath={"contract"}, forceinline=True)


def read_only(*arguments: Any) -> list[Any]:  # noqa: ANN401 - whatever a kernel takes
    """Return arguments of a kernel, arrays as views that cannot be written to: Numba compiles a
    kernel again for each combination of arrays of the two kinds.
    """
    given = [each.view() if isinstance(each, np.ndarray) else each for each in arguments]
    for each in given:
        if isinstance(each, np.ndarray):
            each.flags.writeable = False
    return given
