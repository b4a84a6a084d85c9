"""The machine that a description means: found from where its axes and points are."""
