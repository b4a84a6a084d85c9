"""Maps from what is known to what is wanted: of platforms, rods and joints, with their rates, and
the program of one.
"""
