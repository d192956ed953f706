"""Evidence on disk: one file per problem, with a row for each scheme and block, keyed by its ingredients."""
