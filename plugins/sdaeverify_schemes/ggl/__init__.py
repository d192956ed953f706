"""Implicit Euler steps in GGL form: equations, Newton's method, line search, continuation."""
