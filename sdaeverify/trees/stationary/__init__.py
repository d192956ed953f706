"""Order conditions of the invariant measure of overdamped dynamics, by integrations by parts."""
