"""Loads at rest: what joints carry and how far the tool gives, the largest payload, and one bearing
under one load.
"""
