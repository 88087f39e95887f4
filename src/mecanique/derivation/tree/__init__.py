"""The tree of links and joints, and its poses in any scalar arithmetic."""
