"""Evidence on disk: one file for each scheme, problem and block, under a hash of everything that determines it."""

from .files import StoredLane, joined, read_lane
from .store import Place, Recalled, Store, keep, saved_meanwhile

__all__ = [
    "Place",
    "Recalled",
    "Store",
    "StoredLane",
    "joined",
    "keep",
    "read_lane",
    "saved_meanwhile",
]
