"""The error model of an arm as tables, for a controller: prediction and compensation in fixed time,
in Python and as C source.
"""
