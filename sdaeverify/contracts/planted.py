"""A planted bug: a scheme that is wrong on purpose, with the claims that its author would make.

The program has to refute each of them, or its verdicts mean nothing; `selftest` counts which check refutes which.
"""

from dataclasses import dataclass

from ..errors import SchemeError
from .scheme import Scheme

PREFIX = "planted-"


@dataclass(frozen=True, kw_only=True)
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
        if not self.scheme.name.startswith(PREFIX):
            raise SchemeError(f"the name of a planted scheme must begin with {PREFIX}, got {self.scheme.name!r}")
        if not self.scheme.promises:
            raise SchemeError(f"planted scheme {self.scheme.label!r} claims nothing that could be refuted")

    @property
    def label(self) -> str:
        """The scheme's label and the problem's: no other planted bug has the same."""
        return f"{self.scheme.label} on {self.problem}"
