"""Every mode over a grid or a random sample of inputs or poses, by any executor, into labelled
arrays on disk.
"""
