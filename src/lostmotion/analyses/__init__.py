"""One folder per question: what is computed, its tables, its plots, its command."""
