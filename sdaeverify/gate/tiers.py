"""Tiers: how much a gate spends, and on what."""

import hashlib
from collections.abc import Mapping
from dataclasses import dataclass
from datetime import date
from enum import StrEnum
from types import MappingProxyType

from ..contracts.settings import Settings


class Cover(StrEnum):
    """Which of the claimed cells are run."""

    EVERY_CLAIM_ONCE = "every claim once"
    EVERYTHING = "every claimed cell"


@dataclass(frozen=True)
class Tier:
    """A budget.

    Attributes
    ----------
    name : str
    words : str
        What it is for.
    settings : Settings
        Sample size, step sizes and looks; seed and confidence are those of the policy.
    cover : Cover
    lengthy : bool
        Whether measures are run that take seconds a cell, if the policy does not name them.
    controls : bool
        Whether nothing is verified on a problem that does not tell right from wrong.
    fails_undecided : bool
        Whether a claim that stays undecided fails the gate, unless the policy says otherwise.
    """

    name: str
    words: str
    settings: Settings
    cover: Cover
    lengthy: bool
    controls: bool
    fails_undecided: bool


# From 800 paths on, paths may refute; most cells are decided after the first 256.
SMOKE = Tier(
    "smoke",
    "every claim of the quick measures on the cheapest problem that tests it, in seconds",
    Settings(paths=800, levels=5, looks=3),
    Cover.EVERY_CLAIM_ONCE,
    lengthy=False,
    controls=False,
    fails_undecided=False,
)
CI = Tier(
    "ci",
    "every claimed cell at a small budget, for each change",
    Settings(paths=1024, looks=3),
    Cover.EVERYTHING,
    lengthy=True,
    controls=True,
    fails_undecided=False,
)
NIGHTLY = Tier(
    "nightly",
    "every claimed cell at the full budget, on a schedule",
    Settings(),
    Cover.EVERYTHING,
    lengthy=True,
    controls=True,
    fails_undecided=True,
)
TIERS: Mapping[str, Tier] = MappingProxyType({tier.name: tier for tier in (SMOKE, CI, NIGHTLY)})


# Seeds of a gate: the same each time, or a new one each day that anybody can compute again.


def seed_of(day: date) -> int:
    """Return the seed of a day: the first 63 bits of a hash of its date, so that nobody chooses it."""
    digest = hashlib.blake2b(f"sdaeverify gate {day.isoformat()}".encode(), digest_size=8).digest()
    return int.from_bytes(digest, "big") >> 1
