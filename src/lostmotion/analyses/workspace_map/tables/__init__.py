"""Tables of an accuracy map."""
