"""Sizes of an arm's parts: lightest sections of links, and the cheapest parts for a target."""
