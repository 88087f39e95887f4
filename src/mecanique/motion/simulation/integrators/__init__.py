"""What advances a motion: each method and what it needs, in its own module."""
