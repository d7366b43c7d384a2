"""Covariance of many estimates by few directions: those that move the tool most."""

from __future__ import annotations

from typing import TYPE_CHECKING, Final

import numpy as np

from lostmotion.controller_model.percentile import percentile95

if TYPE_CHECKING:
    from lostmotion.spatial import Floats

# Change of the mean 95 % radius of the tool that is accepted.
_CHANGE: Final = 0.005


def reduced(columns: Floats, covariance: Floats) -> Floats:
    """Return a factor F (estimate, direction) of as few directions as possible, such that F F' in
    place of the covariance changes the mean 95 % radius of the tool by at most 0.5 %.

    columns     (pose, 3, estimate) motion of the tool point per unit of each estimate, m
    covariance  (estimate, estimate)

    The directions are principal for the mean square motion of the tool. Combinations of estimates
    that cancel at the tool are dropped.
    """
    values, vectors = np.linalg.eigh(covariance)
    root = vectors * np.sqrt(np.maximum(values, 0.0))
    moved = columns @ root
    weight = np.einsum("pik,pil->kl", moved, moved)
    _, across = np.linalg.eigh(weight)
    factor, moved = root @ across[:, ::-1], moved @ across[:, ::-1]
    whole = _mean_radius(moved)
    low, high = 1, factor.shape[1]
    while low < high:
        middle = (low + high) // 2
        if _mean_radius(moved[:, :, :middle]) >= (1 - _CHANGE) * whole:
            high = middle
        else:
            low = middle + 1
    return np.asarray(factor[:, :high])


def _mean_radius(moved: Floats) -> float:
    """Return the mean 95 % radius of the tool (m) for independent motions (pose, 3, direction)."""
    covariance = moved @ moved.transpose(0, 2, 1)
    return float(percentile95(np.zeros((len(moved), 3)), covariance).mean())
