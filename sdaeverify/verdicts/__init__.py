"""From a claim to its verdict: coverage, tests, opinions, rules.

A measure takes the first steps for each of its quantities:

`coverage`
    Select the strongest claim of the scheme about the quantity.
`path_tests`
    Compute p-values from paths, and decide whether levels and sample size suffice to use them.
`opinions`
    Form an opinion, from one step if it decides, guarded by paths; otherwise from paths alone. Together with the
    quantity it is a finding.

A study takes the last step, which is the same for all measures: `rules.send` applies `rules.RULES` to the finding.
"""
