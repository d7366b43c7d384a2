"""The front door: one file per verb, with what its answer can be asked."""
