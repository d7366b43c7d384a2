"""Finite elements of a loaded cycloidal stage: outlines, meshes, contact, fields. Everything but
the outlines needs NGSolve, the extra `fem`.
"""
