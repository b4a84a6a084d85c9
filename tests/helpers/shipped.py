"""Shipped mechanisms by their form: limbs between a base and a platform and serial arms, or graphs of links."""

import symkin

LIMBS = [name for name in symkin.shipped_names() if not symkin.load(name).is_graph]
GRAPHS = [name for name in symkin.shipped_names() if name not in LIMBS]
UNDRIVEN = ["five_link_suspension"]
"""Graphs whose actuated joints leave a motion free: other coordinates decide their configurations."""
