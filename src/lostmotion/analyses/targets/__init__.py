"""Allowances of parts for a target on the tool, and production yield."""
