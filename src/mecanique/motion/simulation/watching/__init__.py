"""What is watched while a mechanism moves: limits, contacts, drift and events."""
