"""Watch a motion while it is integrated: limits, contacts, drift and events."""
