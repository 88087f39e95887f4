"""Store, export and plot motions."""
