"""ISO 9283: predicted and measured pose and path characteristics."""
