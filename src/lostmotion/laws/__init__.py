"""Laws of physics, geometry and statistics, each with its source; arrays in, arrays out, no product
names.
"""
