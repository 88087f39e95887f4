"""The search for what explains a disagreement."""
