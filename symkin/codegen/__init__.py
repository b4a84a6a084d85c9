"""Write code from the closure: C99 folders for controllers, and Jacobians in C, NumPy, SymPy and
LaTeX.

A folder of C: `folder` writes the files, `options` says what can be chosen, `program` chooses the
kind of the machine that a description means, `vectors` (on `samples`) and `readme` make its test
and its README, `described` holds the vectors against the description. The
kinds, whose geometry is numbers or a struct (`geometry`): `rod_platform`, `rod_platform_source`
(six rods, with `rod_kernel`, `home_pose`); `limb_platform`, `limb_platform_source` (any limbs, with
`limb_source`, `pose_coordinates`); `serial_arm`; `joint_map`, `joint_map_source` (maps between
joints, with `closed_direction` where formulas solve one, `circle_kernel` and `circles`, which know
angles by cosine and sine, `joint_map_vectors`, `joint_map_readme`).

Newton's method: `newton_kernel` states what an iteration computes, `newton_source` writes it,
`linear_solver` its LU or QR.

Text: `c_emitter` turns CasADi graphs into C, `c_templates` fills `templates/`, which holds the C
that is the same for every mechanism; `expression` writes graphs in other languages, `latex` in
LaTeX (with `simplification`).

Jacobians: `jacobian_formats` lists the formats, `jacobian_header` writes what each begins with,
`jacobian_c`, `jacobian_python`, `jacobian_latex` the rest.
"""
