"""The tolerances by which configurations are judged, each with its unit and reason.

What is singular depends on what is asked of a matrix, so that there is no single threshold. With
s_1 >= ... >= s_r the singular values of a Jacobian whose generic rank is r, lengths in rows and
columns alike (angles times the size):

    s_r / s_1 < 1e-15, or s_r < NO_MOTION   its entries are rounding: the condition is infinite
    s_r / s_1 < RANK_TOLERANCE (1e-8)       the rank is less: rank, mobility, null spaces
    s_1 / s_r > SINGULAR_CONDITION (1e8)    the same number, said of a solution: half of its digits
                                            are lost
    s_r < SINGULAR_VALUE (1e-6)             a configuration at which a rank that generic ones have
                                            is lost: singularities, loci
    s_1 / s_r > SUSPECT_CONDITION (1e6)     the same, said of a root or a start: it may be one of a
                                            continuum, or several in one
    s_r / s_1 < MULTIPLE_ROOT_SHARE (1e-5)  at a root of several paths, known to half of the digits
                                            only: the rank there is less

Elsewhere the question is another one, and its constant stands beside it: whether a Newton step from
a start is worth taking (`position.moved_starts`), which joints follow a pose
(`position.feasible_pose`), which parameters data tell (`calibration`).
"""

from __future__ import annotations

CLOSURE_TOLERANCE = 1e-9
"""Of the size: a configuration is no solution when a closure error exceeds this. Doubles leave
1e-15; geometry written with ten digits, 1e-10. What lies within is judged together with its
conditioning (see `root_checks`).
"""

CLOSURE_ROUNDING = 2.0**-47
"""Of the size, or of the farthest coordinate where that is more: rows up to this are rounding. 32
units in the last place; roots that are polished leave 1 to 5.
"""

RANK_TOLERANCE = 1e-8
"""Share of the largest singular value below which others count as zero: half of a double's digits,
between the rounding of Jacobians (1e-15) and the smallest ratios of mechanisms in use (1e-4).
"""

CLEAR_GAP = 1e3
"""A smaller ratio between the last kept and the first dropped singular value is worth a warning."""

SINGULAR_CONDITION = 1e8
"""Condition above which a solution is called singular: 1 / RANK_TOLERANCE."""

SINGULAR_VALUE = 1e-6
"""Singular value (rows and columns in lengths, of unit length or over the largest) below which a
rank is lost at a configuration that is judged beside generic ones. Where two solutions meet they
are known to the root of a double's precision, and with them the singular value that vanishes there
to about 1e-8: this is a hundred times that. RANK_TOLERANCE is for configurations that are known to
full precision.
"""

SUSPECT_CONDITION = 1e6
"""Condition above which a root is examined for being one of a continuum, before it is called
isolated: 1 / SINGULAR_VALUE.
"""

MULTIPLE_ROOT_SHARE = 1e-5
"""Share of the largest singular value below which a direction counts as lost at a multiple root:
such a root is known to the square root of rounding (1e-8), and so are the singular values that
vanish there, times curvature.
"""

NO_MOTION = 1e-13
"""Singular value (rows per motion, both lengths) below which unknowns do not move the rows; joints
that matter give 1e-6 and more, rounding of a pose's numbers 1e-16.
"""

ROUNDED_STEP = 1e-13
"""Share of the largest singular value below which a Newton step would follow rounding: such
directions are left alone.
"""

FREE_DIRECTION = 1e-10
"""Share of the largest singular value below which a direction in which roots are not isolated is
lost: near such a set a step along it follows what rounding and the curvature of the set leave
there.
"""

WELL_CONDITIONED = 1e8
"""Bound on |J| |J^-1| up to which elimination gives a Newton step as good as the singular value
decomposition's.
"""

GRAM_CONDITION = 1e3
"""Condition up to which J^T J gives it to ten digits: eigenvalues have errors of 1e-16 of the
largest, 1e-10 of the smallest.
"""

CLOSED_CONFIGURATION = 1e-10
"""Of the size: largest closure error of configurations that are sought to look at the mechanism
there, not to be answers.
"""

FILE_DIGITS = 1e-5
"""Of the size: loops that leave less at least-squares configurations are closed to the digits of a
file; and the share of the largest singular value below which others are zero to these digits. Files
are written with five digits and more.
"""

ROOT_POLISHED = 1e-9
"""Largest last Newton step, relative to max(1, |z|), of a path that has arrived: the next one, its
square, is rounding.
"""

ROWS_CONTRADICT = 1e-6
"""Largest row, relative to 1, that the end of a path may leave: above it, redundant rows contradict
each other.
"""

DISTINCT_ROOTS = 1e-6
"""Of the size: polished roots within this of each other are one; their rounding is 1e-15 times the
condition.
"""

LIMIT_SLACK = 1e-9
"""What a joint may lie beyond its limits by rounding: rad, or of the size."""

ROUNDED_COMPONENT = 1e-12
"""Components of a unit quaternion below this are zero to rounding and do not decide its sign."""
