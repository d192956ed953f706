"""Local errors: defects of one step, and the orders they tell."""
