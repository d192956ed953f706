"""Simulation: the time loop, the states of schemes, the exact solution on the same noise, and replicated chains."""
