"""Equations with several Brownian motions: what depends on time, and which areas and products count."""
