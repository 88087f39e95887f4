"""The random states at which both sides are compared."""
