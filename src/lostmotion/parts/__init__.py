"""Things you buy or make: fields with units, plus the laws that apply to them, give elementary
errors.
"""
