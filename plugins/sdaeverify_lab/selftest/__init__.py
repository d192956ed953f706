"""Test of the program on schemes that are known to be wrong, and on those that are known to be right."""

from .kills import BugResult, KillMatrix, Refuter, kill_matrix
from .trial import SelfTest, selftest_trial

__all__ = ["BugResult", "KillMatrix", "Refuter", "SelfTest", "kill_matrix", "selftest_trial"]
