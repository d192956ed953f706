"""Comparison of runs: changed verdicts, and changes of orders and errors on common noise.

::

    folder      the evidence of a run, as it was stored          sdaeverify.studying.StoredRun
    evidence    errors of either run, quantity by quantity       cells
    factors     new error over old error, with an interval       factors
    changes     same, worse, better, undecided                   changes
"""
