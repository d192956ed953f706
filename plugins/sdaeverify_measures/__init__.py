"""Measures for papers: each module is a plugin, with the probes that only it uses."""
