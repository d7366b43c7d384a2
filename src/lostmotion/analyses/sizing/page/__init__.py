"""Pages of sized links and of selected parts."""
