"""Numbers for many points at once: systems of rows, rank, least squares, compiled libraries and
files kept between runs.
"""
