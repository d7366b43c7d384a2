"""From a target back to the parts, and forward to the share of robots that keep it."""
