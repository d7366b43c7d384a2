"""Questions asked of an arm."""
