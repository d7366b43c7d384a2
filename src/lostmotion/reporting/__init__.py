"""Sheets, plots, pages and folders: they show any analysis and compute nothing."""
