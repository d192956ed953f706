"""Probing: evaluation of a scheme's one-step map at cubature nodes, so that verdicts need no sampling."""
