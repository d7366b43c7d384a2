"""Holding torques, bearing loads and compliance of an arm at rest."""
