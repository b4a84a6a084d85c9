"""Write code from the closure: C99 folders for controllers, and Jacobians in C, NumPy, SymPy and
LaTeX. Each of these packages reads those before it:

`text`: `graph` makes nodes of a CasADi function, constants folded and signs drawn out, `printer`
prints them by a language's table of operations: `c` (which has the type of numbers and the emitter
of statements), `languages` and `javascript`; `latex` writes a closure's equations, `jacobians`
Jacobians in each format. Expressions are made shorter by `gathered` (Horner) and `angles` (cosines
and sines in place of angles). `templates` fills `templates/`, which holds the C that is the same
for every mechanism (what several say are the macros of `macros.h`), `c` gives all of it its names
and the type of its numbers, `width` breaks its lines.

`steps`: how a part of a problem is solved. `newton_kernel` states what an iteration computes
(`circle_kernel`: angles by cosine and sine; `pose_kernel`, `rod_kernel`: over a pose alone),
`newton_source` writes it, `linear_solver` its LU or QR. `composed` puts the formulas of a problem's
parts together, `direct_formulas` and `limbwise` find those of platforms; `guards` bounds what must
stay above zero along a line, `guard_text` writes that. `geometry` is numbers or a struct.

`map`: `options` says what can be chosen, `record` what is asked of every kind of machine and of
what writes it, `program` chooses what the machine that a description means is: `limb_platform`,
`limb_platform_source` (any limbs, with `limb_source`), of which `rod_platform`,
`rod_platform_source` are those on six rods (with `home_pose`); `joint_map`, `joint_map_source`
(maps between joints, with `map_direction`). `rates` differentiates a map's rows and reads rates
from a step, `signature` has the functions of the interface.

`folder`: `folder` writes the files; `vectors` (of arms `arm_vectors`, what is refused
`refused_vectors`), `own_test_text` and `readme` make test and README, `described` holds the vectors
against the description.

Beside them: arms (`serial_arm`, `closed_source`, `closed_line`, `arm_bounds`), what formulas of
platforms and maps print (`closed_direct_source`, `closed_direction`, `closed_limb`), and the most
that a call takes (`worst_case`).
"""
