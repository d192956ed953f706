"""Diffusions and mechanics on spheres and products of spheres."""
