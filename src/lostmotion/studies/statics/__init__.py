"""At rest: what joints carry and how much everything gives."""
