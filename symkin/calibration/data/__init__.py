"""What was measured: readings and their files, and the parameters of a mechanism that they may
tell.
"""
