"""Whether intervals and tests keep what they promise: tried out over many seeds on cells whose truth is known.

Each rate is a share of independent trials with its binomial interval. It is compared with a promise that was made
before: an interval covers at its nominal level within 0.02, a one-sided tail is at most twice its nominal level,
whole procedures err at most at theirs. Where nothing is promised, as for the L2 norm of heavy-tailed errors or for
differences lost in noise, the rate shows why.
"""
