"""One bearing by itself."""
