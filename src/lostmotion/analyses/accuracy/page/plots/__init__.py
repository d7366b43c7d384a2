"""Plots of this analysis."""
