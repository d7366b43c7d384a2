"""Sizing of links by limits, and selection of parts for a target."""
