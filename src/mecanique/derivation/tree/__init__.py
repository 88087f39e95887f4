"""The tree of links and joints, and its poses over any scalar."""
