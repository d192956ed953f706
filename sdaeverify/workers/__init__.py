"""Code of plugins in processes of its own: pools, limits and calls."""
