"""Shipped mechanisms by their form: limbs between a base and a platform and serial arms, or graphs
of links.
"""

import symkin

LIMBS = [name for name in symkin.shipped_names() if not symkin.load(name).is_graph]
GRAPHS = [name for name in symkin.shipped_names() if name not in LIMBS]
UNDRIVEN = ["five_link_suspension"]
"""Graphs whose actuated joints leave a motion free: other coordinates decide their
configurations.
"""
TWELVE = [
    "ankle",
    "bennett",
    "hexapod_stack",
    "jansen_leg",
    "parallel_gripper",
    "sarrus",
    "scara",
    "slider_crank",
    "spherical_wrist",
    "ur5e",
    "zhang2009",
    "zhao2000",
]
"""A covering set, on which the gate tries laws that take long: arms with and without a slide, limbs
of six freedoms and of a declared motion, graphs that are planar, spherical, spatial,
overconstrained, with rods, slides and couplings.
"""
