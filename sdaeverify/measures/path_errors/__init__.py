"""Pathwise errors: their accumulation on a block, and the order estimated from paths."""
