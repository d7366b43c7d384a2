"""Gearboxes, one file per kind."""
