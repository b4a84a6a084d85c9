"""One mode followed along a path of joints or poses, with proofs, and the graph of modes over a
slice.
"""
