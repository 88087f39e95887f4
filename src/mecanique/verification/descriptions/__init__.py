"""Compare two descriptions: what changed, by its weight in the dynamics."""
