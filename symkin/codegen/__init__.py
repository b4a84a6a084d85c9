"""Code written from the closure: C99 folders for controllers, and Jacobians in C, NumPy, SymPy and LaTeX.

`options` says what can be chosen, `folder` writes the files; `emit` turns CasADi graphs into C, `kernel` states what is
solved, `factor` how its linear systems are, and `templates/` holds the C that is the same for every mechanism.
"""
