"""Ito equations dx = f(t, x) dt + B(t, x) dW."""
