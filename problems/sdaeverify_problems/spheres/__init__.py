"""Diffusions and mechanics on spheres and products of them."""
