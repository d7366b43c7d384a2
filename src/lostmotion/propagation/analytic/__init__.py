"""Without sampling: sums over terms."""
