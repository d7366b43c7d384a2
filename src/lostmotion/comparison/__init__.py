"""What differs between arms that are studied with the same draws, and what it does."""
