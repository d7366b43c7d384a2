"""The contents of the catalogue."""
