"""Inextensible fibres in a turbulent flow: chains, constraints, forces and noise."""
