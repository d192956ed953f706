"""Runs: the only time loop, what it advances, the truth on the same noise, and replicated chains."""
