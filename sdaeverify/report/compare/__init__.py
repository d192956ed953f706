"""Two runs compared: by which factor errors have grown or shrunk, on the noise that both runs share.

::

    folder      the evidence of a run, as it was stored          runs
    evidence    errors of either run, quantity by quantity       cells
    factors     new error over old error, with an interval       factors
    changes     same, worse, better, undecided                   changes
"""
