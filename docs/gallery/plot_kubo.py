"""
Kubo oscillator
===============

A rotation with a noisy frequency keeps its length.
"""

print(1)
