"""Code of plugins in processes of its own: pools, limits, calls, and the supervision of the program."""
