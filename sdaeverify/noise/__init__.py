"""Noise addressed by seed, problem, block and level, and the laws of increments."""
