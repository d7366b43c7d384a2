"""Robots put through the tests of ISO 9283: test cube, motion between its poses, figures."""
