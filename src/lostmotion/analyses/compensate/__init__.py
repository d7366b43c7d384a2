"""Corrected joint values for a machine: poses or a program in, the same file corrected out."""
