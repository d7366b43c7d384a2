"""An arm in the browser: its error at any pose, with the parts that cause it."""
