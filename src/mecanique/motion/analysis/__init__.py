"""Analyze a motion: forces, momenta, audits."""
