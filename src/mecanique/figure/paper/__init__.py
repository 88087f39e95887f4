"""A figure on paper: marks, signs and letters, and the files they are written to."""
