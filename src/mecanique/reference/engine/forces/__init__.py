"""What acts on the engine's bodies: loads, what elements do, and reactions."""
