"""Evidence on disk: one file a problem, a row in it for each scheme and block, by what determines it."""
