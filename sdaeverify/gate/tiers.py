"""Tiers: how much a gate spends, and on what."""

import hashlib
from collections.abc import Mapping
from dataclasses import dataclass
from datetime import date
from types import MappingProxyType

from ..contracts.settings import Settings


@dataclass(frozen=True)
class Tier:
    """A budget.

    Attributes
    ----------
    settings : Settings
        Sample size, step sizes and looks; seed and confidence are those of the policy.
    quick : bool
        Whether each claim is tested once, on the cheapest problem that can decide it, without measures that take
        seconds a cell if the policy does not name them, and without controls; if not, every claimed cell is run, and
        nothing is verified on a problem that does not tell right from wrong.
    fails_undecided : bool
        Whether a claim that stays undecided fails the gate, unless the policy says otherwise.
    hunts : bool
        Whether counterexamples are looked for, if the policy says how long.
    """

    settings: Settings
    quick: bool = False
    fails_undecided: bool = False
    hunts: bool = False


# From 800 paths on, paths may refute; most cells are decided after the first 256.
TIERS: Mapping[str, Tier] = MappingProxyType(
    {
        "smoke": Tier(Settings(paths=800, levels=5, max_looks=3), quick=True),  # in seconds
        "ci": Tier(Settings(paths=1024, max_looks=3)),  # for each change
        "nightly": Tier(Settings(), fails_undecided=True, hunts=True),  # on a schedule
    }
)


# Seeds of a gate: the same each time, or a new one each day that anybody can compute again.


def seed_of(day: date) -> int:
    """Return the seed of a day: the first 63 bits of a hash of its date, so that nobody chooses it."""
    digest = hashlib.blake2b(f"sdaeverify gate {day.isoformat()}".encode(), digest_size=8).digest()
    return int.from_bytes(digest, "big") >> 1
