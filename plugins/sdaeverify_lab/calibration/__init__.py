"""Calibration of intervals and tests, over many seeds on cells with known truth.

Each rate is a fraction of independent trials with its binomial interval. It is compared with a prescribed range: an
interval covers at its nominal level within 0.02, a one-sided tail is at most twice its nominal level, and whole
procedures have at most their nominal error probability. Where no range is prescribed, as for the L2 norm of
heavy-tailed errors or for differences lost in noise, the rate shows the reason.
"""
