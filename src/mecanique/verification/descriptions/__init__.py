"""Two descriptions compared as descriptions: what changed, by its weight in the dynamics."""
