"""Delay equations, with moments and stationary laws by renewal equations."""
