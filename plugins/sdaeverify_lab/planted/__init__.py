"""Shipped wrong schemes, one family per file: the program has to refute each of them."""
