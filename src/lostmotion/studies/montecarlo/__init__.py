"""Robots built and visits made: what Monte Carlo says."""
