"""Export of an arm's model to a controller."""
