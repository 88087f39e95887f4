"""The scene as pure data, made from a motion."""
