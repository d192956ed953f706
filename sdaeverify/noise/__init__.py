"""Noise by address, and the laws of increments."""
