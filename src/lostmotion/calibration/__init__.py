"""Calibration: which of the robots that an arm's file describes was measured."""
