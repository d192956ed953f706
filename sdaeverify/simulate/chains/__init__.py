"""Replicated chains: time averages of observables at several step sizes on the same noise.

A chain is a path that runs long enough to forget its start. Chains are independent of each other, so that means over
groups of them have an error that is known without any model of correlations in time; step sizes h, h/2, ... share
their noise, so that differences between them are known far better than the means themselves. The coarsest mean is
known worst and costs least: it is taken from many more chains of that step size alone.
"""

from .chains import Chains
from .pilot import CONTRACTING, Pilot, run_pilot
from .plan import GROUPS, Plan
from .record import ChainRecord, grouped, run_chains

__all__ = ["CONTRACTING", "GROUPS", "ChainRecord", "Chains", "Pilot", "Plan", "grouped", "run_chains", "run_pilot"]
