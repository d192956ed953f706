"""Equations with a delay: moments and stationary laws by renewal equations."""
