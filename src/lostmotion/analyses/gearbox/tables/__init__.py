"""Tables of this analysis."""
