"""Probing: the one-step map of a scheme evaluated at cubature nodes, so that no verdict rests on sampling."""
