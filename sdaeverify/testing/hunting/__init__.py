"""The hunt for counterexamples: drawn at random, decided by one step, shrunk, confirmed by a run."""
