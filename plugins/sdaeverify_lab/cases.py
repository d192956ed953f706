"""Test cases for the verifier: planted bugs, and cells of known order for the calibration.

A planted bug is a deliberately wrong scheme with the claims that its author would make. The program has to refute
each of them; `selftest` counts which check refutes which. Calibration cases test intervals and tests over many seeds.
"""

from dataclasses import dataclass

from sdaeverify import ProblemError, Scheme, SchemeError
from sdaeverify.studying import check_scheme, parse_label

PREFIX = "planted-"


@dataclass(frozen=True)
class Planted:
    """A wrong scheme and the problem on which it must be refuted.

    Attributes
    ----------
    bug : str
        Description of the bug.
    scheme : Scheme
        Wrong scheme with at least one claim, whose name begins with ``planted-`` to distinguish it.
    problem : str
        Label of a registered problem.
    equivalent : str
        Why the claims hold in spite of the change, so that the scheme must not be refuted; empty for a bug.
    """

    bug: str
    scheme: Scheme
    problem: str
    equivalent: str = ""

    def __post_init__(self) -> None:
        if not self.bug.strip():
            raise SchemeError("a planted bug must say in words what is wrong")
        check_scheme(self.scheme)
        parse_label(self.problem)
        if not self.scheme.name.startswith(PREFIX):
            raise SchemeError(f"the name of a planted scheme must begin with {PREFIX}, got {self.scheme.name!r}")
        if not self.scheme.promises:
            raise SchemeError(f"planted scheme {self.scheme.label!r} claims nothing that could be refuted")

    @property
    def label(self) -> str:
        """Labels of the scheme and the problem, which identify the planted bug."""
        return f"{self.scheme.label} on {self.problem}"


@dataclass(frozen=True, kw_only=True)
class CalibrationCase:
    """A scheme on a problem, and the statistics to calibrate there.

    Attributes
    ----------
    scheme, problem : str
        Labels of a registered scheme and problem.
    order : float
        Known strong order of the scheme on the problem.
    strong : bool
        Whether the statistics of pathwise errors are calibrated.
    weak, stationary : tuple of str
        Observables whose mean differences between step sizes, and time averages along chains, are calibrated.
    heavy : bool
        Whether few paths dominate the mean error, so that no range is prescribed for small samples.
    share : float
        Fraction of the repetitions to run, for costly cells.
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
        """Labels of the scheme and the problem."""
        return f"{self.scheme} on {self.problem}"
