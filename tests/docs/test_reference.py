"""Docstrings of the public names, as the reference of the site reads them."""

from __future__ import annotations

import inspect
import re

import pytest

import lostmotion

# The site takes the type and the default of the first name for all names of such a row.
_SHARED_ROW = re.compile(r"^\w+(?:, ?\w+)+(?: ?:.*)?$\n(?=    \S)", re.MULTILINE)


@pytest.mark.parametrize("name", lostmotion.HOMES)
def test_each_parameter_of_a_public_name_is_documented_by_itself(name):
    """No row of a section names several parameters, whose types and defaults may differ."""
    assert not _SHARED_ROW.findall(inspect.getdoc(getattr(lostmotion, name)) or "")


def test_a_row_of_several_parameters_would_be_found():
    """The search is able to fail."""
    rows = "Parameters\n----------\nposes, robots : int\n    As in `study`.\nseed\n    Of draws.\n"
    assert len(_SHARED_ROW.findall(rows)) == 1
