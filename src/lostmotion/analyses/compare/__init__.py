"""What differs between arms, and what it does to accuracy, mass and drives."""
