"""Every mode of a position problem: by paths with a statement of completeness, or by many starts."""
