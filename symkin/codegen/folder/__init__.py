"""What stands in a folder beside the code: vectors and test, example, README, build files, other
languages' headers and components.
"""
