"""Fixtures of the tests of sizing."""

import pytest

from lostmotion.analyses.sizing import sizing


@pytest.fixture
def few_scales(monkeypatch):
    """Compute the trade-off at two limits in place of nine, where it is not what is tested."""
    monkeypatch.setattr(sizing, "SCALES", (1.0, 2.0))
