"""Sizes of an arm's parts: lightest sections, cheapest parts, and allowances for a target."""
