"""The tables of a run: what their columns are, how findings become rows, and the command that makes one again."""
