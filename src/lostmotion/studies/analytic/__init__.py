"""Without sampling: what sums over terms say."""
