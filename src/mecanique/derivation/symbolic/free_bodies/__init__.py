"""Every body cut free: its axes, what acts on it, and how reactions are eliminated."""
