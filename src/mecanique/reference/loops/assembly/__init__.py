"""Bring a mechanism onto its loops: from next to them, from far away, anywhere."""
