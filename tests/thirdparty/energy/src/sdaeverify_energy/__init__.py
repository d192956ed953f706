"""Energy drift as a measure, a problem that keeps its energy, and schemes that do so with order 1 and 1/2."""
