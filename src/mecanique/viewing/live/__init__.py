"""The scene streamed live to a browser on this machine."""
