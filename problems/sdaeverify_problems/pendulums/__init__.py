"""Pendulums as constrained mechanics and as equations of the angle."""
