"""The program tested on schemes that are known to be wrong, and on those that are known to be right."""

from .kills import BugResult, Check, KillMatrix, kill_matrix
from .trial import Trial, selftest_trial

__all__ = ["BugResult", "Check", "KillMatrix", "Trial", "kill_matrix", "selftest_trial"]
