"""Pictures of mechanisms and results; the text of a result stands beside the result."""
