"""Integrate many motions of a mechanism side by side."""
