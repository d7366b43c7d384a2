"""One gearbox by itself."""
