"""The gate: claims as a policy asks for them, outcomes as a maintainer needs them, reports as a pipeline reads them.

::

    policy    what is gated, how strictly, what is expected to fail      [tool.sdaeverify]
    tiers     how much is spent: smoke, ci, nightly
    plan      the claimed cells, those of a tier's cover
    outcomes  passed, failed, unmeasured, undecided, xfailed, xpassed
    lock      the claims that must be there
"""
