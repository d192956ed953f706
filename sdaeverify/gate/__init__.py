"""The gate: the policy of a project, the outcomes of its claims, and reports for terminals and CI services.

::

    policy    what is gated, how strictly, what is expected to fail      [tool.sdaeverify]
    tiers     budgets: smoke, ci, nightly
    plan      the claimed cells of a tier
    outcomes  passed, failed, unmeasured, undecided, xfailed, xpassed
    lock      the claims that a gate must find
"""
