"""C99 for controllers: direct and inverse kinematics of one mechanism as a small folder of sources.

`options` says what can be chosen, `folder` writes the files; `emit` turns CasADi graphs into C, `kernel` states what is
solved, `factor` how its linear systems are, and `templates/` holds the C that is the same for every mechanism.
"""
