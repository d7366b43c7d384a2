"""Tables of an ISO 9283 sheet."""
