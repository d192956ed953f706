"""Schemes for holonomic constraints that project positions or velocities."""
