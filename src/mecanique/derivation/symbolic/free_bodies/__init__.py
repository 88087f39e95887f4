"""Cut bodies free: choose their axes, collect the forces on them, eliminate reactions."""
