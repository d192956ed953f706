"""Run plugin code in separate processes: worker pools, resource limits and calls."""
