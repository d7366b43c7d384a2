"""Does a task succeed: the probability that an arm meets all of its tolerances."""
