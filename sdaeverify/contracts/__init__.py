"""What plugins give and get: schemes, claims, measures, settings, labels, and how schemes match problems."""
