"""Diffusions on matrix manifolds: orthogonal groups and Stiefel manifolds."""
