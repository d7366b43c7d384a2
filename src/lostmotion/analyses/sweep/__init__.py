"""Many designs, or one large run."""
