"""What the verifier itself is tried out on: planted bugs, and cells of known order for the calibration.

A planted bug is a scheme that is wrong on purpose, with the claims that its author would make. The program has to
refute each of them, or its verdicts mean nothing; `selftest` counts which check refutes which. On a calibration case
intervals and tests are tried out over many seeds.
"""

from dataclasses import dataclass

from sdaeverify import ProblemError, Scheme, SchemeError
from sdaeverify.studying import check_scheme, parse_label

PREFIX = "planted-"


@dataclass(frozen=True)
class Planted:
    """A wrong scheme and the problem on which it has to be found out.

    Attributes
    ----------
    bug : str
        What is wrong, in words.
    scheme : Scheme
        Its name begins with ``planted-``, so that it passes for no other, and it claims something.
    problem : str
        Label of a registered problem.
    equivalent : str
        Why the scheme keeps its claims in spite of the change, so that it must not be refuted; empty for a bug.
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
        """The scheme's label and the problem's: no other planted bug has the same."""
        return f"{self.scheme.label} on {self.problem}"


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
