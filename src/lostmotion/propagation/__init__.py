"""From the pose matrix to the distribution of the error: Monte Carlo, sums over terms, exact
composition.
"""
