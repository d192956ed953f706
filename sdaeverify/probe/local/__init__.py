"""Local errors: defects of one step, and the orders that follow from them."""
