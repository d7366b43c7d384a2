"""What may be read, and how mistakes are told."""
