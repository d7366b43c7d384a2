"""Tables, bars and headline of a comparison."""
