"""Calibration: which of the robots that an arm's file describes was measured, and how accurate it
will be.
"""
