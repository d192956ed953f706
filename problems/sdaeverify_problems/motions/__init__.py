"""Equations with several Brownian motions, whose solutions depend on time, Levy areas or mixed products."""
