"""Which sections and bought parts an arm needs."""
