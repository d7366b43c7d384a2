"""Monte Carlo: robots and visits."""
