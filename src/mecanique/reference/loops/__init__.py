"""Loops on the engine's tree: constraints, assembly, degrees of freedom, singular positions."""
