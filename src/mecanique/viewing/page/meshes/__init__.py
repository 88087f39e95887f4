"""Meshes for the page: files read here, written small."""
