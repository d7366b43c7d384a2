"""Where in space how accurate."""
