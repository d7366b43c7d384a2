"""Check of a file: what it describes, what is assumed and what is missing, with a picture of the
arm.
"""
