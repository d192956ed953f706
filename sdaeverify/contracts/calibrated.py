"""A case of the calibration: a cell of known order on which intervals and tests are tried out over many seeds."""

from dataclasses import dataclass

from ..errors import ProblemError


@dataclass(frozen=True, kw_only=True)
class CalibrationCase:
    """A scheme on a problem, and what is tried out there.

    Attributes
    ----------
    scheme, problem : str
        Labels of a registered scheme and problem.
    order : float
        Strong order of the scheme there, which is known.
    strong : bool
        Whether the statistics of pathwise errors are tried out.
    weak, stationary : tuple of str
        Observables of which mean differences between step sizes, and time averages along chains, are tried out.
    heavy : bool
        Whether few paths carry much of the mean error, so that nothing is promised for small samples.
    share : float
        Part of the repetitions that are made, for cells that cost more than others.
    """

    scheme: str
    problem: str
    order: float
    strong: bool = True
    weak: tuple[str, ...] = ()
    stationary: tuple[str, ...] = ()
    heavy: bool = False
    share: float = 1.0

    def __post_init__(self) -> None:
        if not self.order > 0.0:
            raise ProblemError(f"a calibration case has a positive order, got {self.order!r}")
        if not 0.0 < self.share <= 1.0:
            raise ProblemError(f"the share of the repetitions must be in (0, 1], got {self.share!r}")

    @property
    def label(self) -> str:
        """The scheme's label and the problem's."""
        return f"{self.scheme} on {self.problem}"
