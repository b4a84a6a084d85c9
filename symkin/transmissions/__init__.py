"""Transmissions: the closed linkages between a robot's motors and the joints of its limbs.

`found` takes the linkages out of a robot, `linkage` writes one as rows of motors and joints with
their derivatives and follows many configurations along straight lines, `polytope` says which
torques and rates are possible, `survey` looks at the whole range, `transmission` is the verb.
"""
