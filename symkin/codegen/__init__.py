"""Write code from the closure: C99 folders for controllers, and Jacobians in C, NumPy, SymPy and
LaTeX.

A folder of C: `folder` writes the files, `options` says what can be chosen, `program` chooses the
kind of the machine that a description means, `vectors` (on `samples`, of arms `arm_vectors`, what
is refused `refused_vectors`) and `readme` make its test and its README, `described` holds the
vectors against the description. The kinds, whose geometry is numbers or a struct (`geometry`):
`rod_platform`, `rod_platform_source` (six rods, with `rod_kernel`, `home_pose`); `limb_platform`,
`limb_platform_source` (any limbs, with `limb_source`, `pose_coordinates`); `serial_arm`;
`joint_map`, `joint_map_source` (maps between joints, with `map_direction`, `closed_direction` where
formulas solve one, `circle_kernel`, which knows angles by cosine and sine). `composed` puts the
formulas of a problem's parts together, `rates` differentiates a map's rows and reads rates from a
step.

Newton's method: `newton_kernel` states what an iteration computes, `newton_source` writes it,
`linear_solver` its LU or QR.

Text: `text/graph` makes nodes of a CasADi function, `text/printer` prints them by a language's
table of operations: `text/c` (which has the type of numbers and the emitter of statements),
`text/languages` and `text/javascript`; `text/latex` writes a closure's equations, `text/jacobians`
Jacobians in each format. Expressions are made shorter by `text/gathered` (Horner),
`text/simplification` (for readers) and `text/angles` (cosines and sines in place of angles).
`text/templates` fills `templates/`, which holds the C that is the same for every mechanism,
`text/width` breaks its lines.
"""
