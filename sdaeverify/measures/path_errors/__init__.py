"""Pathwise errors: what is noted on a block, and the order that paths tell."""
