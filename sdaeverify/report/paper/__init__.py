"""Figures, tables and citations of a result, for a paper."""
