"""Evidence on disk: one file a problem, a row in it for each scheme and block, by what determines it."""

from .container import Container, containers
from .lanes import StoredLane, joined
from .store import FOLDER, Place, Recalled, Store, keep, saved_meanwhile

__all__ = [
    "FOLDER",
    "Container",
    "Place",
    "Recalled",
    "Store",
    "StoredLane",
    "containers",
    "joined",
    "keep",
    "saved_meanwhile",
]
