"""Characteristics of ISO 9283 and ISO 230-2 of a measured robot, and how predicted ones compare."""
