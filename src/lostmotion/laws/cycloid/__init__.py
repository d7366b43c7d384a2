"""Cycloidal drives: geometry, contact, load sharing and tolerances."""
