"""Accuracy maps: cells of the workspace, their configurations and errors, and best placements."""
