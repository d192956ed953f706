"""Seeds of a gate: the same each time, or a new one each day that anybody can compute again."""

import hashlib
from datetime import date


def seed_of(day: date) -> int:
    """Return the seed of a day: the first 63 bits of a hash of its date, so that nobody chooses it."""
    digest = hashlib.blake2b(f"sdaeverify gate {day.isoformat()}".encode(), digest_size=8).digest()
    return int.from_bytes(digest, "big") >> 1
