"""Wrong schemes drawn at random, what they are wrong by, and what the program says of them."""
