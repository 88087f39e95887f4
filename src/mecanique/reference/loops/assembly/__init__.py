"""Assemble a mechanism: close its loops from a position nearby, far away, or without a guess."""
