"""Tests of the tables of a controller, and of their evaluation in Python and in C."""
