"""Search for counterexamples: problems are drawn at random, tested by one step, shrunk, and confirmed by a run."""
