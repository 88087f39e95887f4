"""Close loops on the engine's tree: constraints, assembly, freedom, singular positions."""
