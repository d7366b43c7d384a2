"""How kernels are compiled: cached, without the interpreter's lock, and without fast mathematics, so that every sum runs in its written order."""

from __future__ import annotations

from numba import njit

compiled = njit(nogil=True, cache=True, error_model="numpy", boundscheck=False)
