"""Text of other languages: the graph of an expression, and one printer of it with a table a
language.
"""
