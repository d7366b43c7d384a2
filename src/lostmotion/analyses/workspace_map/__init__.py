"""Accuracy map of an arm over its workspace, and best placement for a task."""
