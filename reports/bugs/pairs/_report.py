"""A public bug report, with the scheme that has the mistake and the mended one."""

from collections.abc import Callable
from dataclasses import dataclass

from sdaeverify import Scheme


@dataclass(frozen=True)
class Report:
    """A bug report and the pair of schemes that was written after it.

    Attributes
    ----------
    scheme : class of a Scheme
        With a parameter ``mended``, true by default.
    url : str
        Address of the issue or pull request.
    mistake : str
        What was wrong, in one sentence.
    problems : str
        Problems on which a user would try the scheme, as `matrix -p` takes them.
    clues : tuple of str
        Words in a reason that name the part of the step in which the mistake is.
    """

    scheme: Callable[..., Scheme]
    url: str
    mistake: str
    problems: str
    clues: tuple[str, ...]

    @property
    def name(self) -> str:
        """Name of the scheme, which is mended; with ``[mended=false]`` it is faulty."""
        return str(self.scheme().name)


def pair_of(report: Report) -> list[Scheme]:
    """Return the mended and the faulty scheme."""
    make = report.scheme
    return [make(), make(mended=False)]
