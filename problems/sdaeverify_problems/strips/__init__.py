"""A curved strip around a line, with a stiff drift to the line."""
