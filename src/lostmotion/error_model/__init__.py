"""Terms of a mechanism as a pose matrix; draws, poses, intervals and the error budget."""
