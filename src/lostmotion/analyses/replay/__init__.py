"""How the largest errors of a run arise."""
