"""Wrong schemes shipped with sdaeverify, one family a file: the program has to refute each of them."""
