"""Tiers: budgets of a gate."""

import hashlib
from collections.abc import Mapping
from dataclasses import dataclass
from datetime import date
from types import MappingProxyType

from ..contracts.settings import Settings


@dataclass(frozen=True)
class Tier:
    """Budget of a gate.

    Attributes
    ----------
    settings : Settings
        Sample size, step sizes and looks; seed and confidence come from the policy.
    quick : bool
        Whether each claim is tested once, on the cheapest problem that can decide it, without controls, and without
        measures that take seconds a cell unless the policy names them. Otherwise every claimed cell is run, and no
        claim is verified on a problem whose controls fail.
    fails_undecided : bool
        Whether an undecided claim fails the gate, unless the policy overrides it.
    hunts : bool
        Whether counterexamples are searched for, if the policy gives a duration.
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


# Seed of a gate that changes daily and can be reproduced from the date.


def seed_of(day: date) -> int:
    """Return the seed of a day: the first 63 bits of a hash of its date, so that it cannot be chosen."""
    digest = hashlib.blake2b(f"sdaeverify gate {day.isoformat()}".encode(), digest_size=8).digest()
    return int.from_bytes(digest, "big") >> 1
