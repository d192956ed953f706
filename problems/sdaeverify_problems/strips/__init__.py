"""A curved strip around a line, with a stiff return to it."""
