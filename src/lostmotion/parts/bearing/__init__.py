"""Bearings, one file per kind."""
