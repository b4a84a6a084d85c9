"""Every mode of a position problem, with a statement of completeness."""
