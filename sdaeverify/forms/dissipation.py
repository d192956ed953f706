"""The constants of condition (4.1) of mean-square stability, Qu, Huang & Liu (2010)."""

from typing import NamedTuple


class Dissipation(NamedTuple):
    """To be completed."""

    abar: float
    al0: float
    al1: float
    al2: float
    be0: float
    be1: float
    be2: float
    L1: float
    L2: float
    L3: float

    @property
    def C(self) -> float:
        """The margin of (4.1)."""
        squares = self.L1**2 * (self.L2**2 + self.L3**2)
        linear = self.al1 + self.al2 * self.L1 * (self.L2 + self.L3)
        return 2 * self.abar - 2 * linear - self.be0 - self.be1 - 2 * self.be2 * squares
