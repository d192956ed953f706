"""Runs compared: verdicts that changed; orders and errors that moved, on the noise that two runs share.

::

    folder      the evidence of a run, as it was stored          runs
    evidence    errors of either run, quantity by quantity       cells
    factors     new error over old error, with an interval       factors
    changes     same, worse, better, undecided                   changes
"""
