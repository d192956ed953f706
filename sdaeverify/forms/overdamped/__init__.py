"""Overdamped Langevin dynamics under a penalised or exact constraint."""
