"""Systems with friction, stops and contacts that open: one module each."""
