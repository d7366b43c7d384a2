"""Reading of files, and messages about mistakes."""
