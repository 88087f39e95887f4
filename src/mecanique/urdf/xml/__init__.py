"""XML text: parse it with line numbers, write it."""
