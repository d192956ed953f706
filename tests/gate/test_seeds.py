"""Seeds of days."""

from datetime import date, timedelta

from facade import seed_of
from sdaeverify import Settings

DAY = date(2025, 3, 1)


def test_seed_of_a_day():
    """Each day has its seed, which is one that settings accept and stays what it is."""
    seeds = [seed_of(DAY + timedelta(days)) for days in range(400)]

    assert len(set(seeds)) == 400
    assert all(Settings(seed=seed).seed == seed for seed in seeds)
    assert seeds[0] == 4746155548087908943
