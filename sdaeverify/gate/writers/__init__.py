"""What a gate writes: one format a file, all from the same record."""
