"""The page that moves: one HTML file with a mechanism in 3-D, its sliders and all of its modes."""
