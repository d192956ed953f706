"""The way of a claim to its verdict: which claim covers a quantity, what was seen of it, what else is known, the row.

A measure goes the first part for each of its quantities:

`coverage`
    the strongest claim of the scheme about the quantity;
`path_tests`
    what paths say of it: p-values, and whether the levels and the sample allow to rely on them;
`opinions`
    what is said of it: one step decides, guarded by paths; else paths alone; or nobody. That makes a finding.

A study goes the second part, which is the same for all measures: `way` is the tuple of rules that a finding passes.
"""
