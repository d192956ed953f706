"""Shares of a search, of so many examples each: what they may cost, what they come to, and how they are kept."""

import hashlib
from collections import Counter
from collections.abc import Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any, NamedTuple

import msgspec

from ...report.files import require_writable, write_whole
from ..strategies.forms import CLASSES

# Examples of a share: its seed is its own, so that it is the same whoever searches it, and when.
SIZE = 50


class Budget(NamedTuple):
    """What a share may cost.

    Attributes
    ----------
    examples : int
        That are drawn; one that is drawn twice is looked at once.
    seconds : float
        Until the first one is found.
    shrinking : float
        Seconds from then on.
    """

    examples: int = SIZE
    seconds: float = float("inf")
    shrinking: float = 60.0


@dataclass(frozen=True)
class Share:
    """What the search of one share has come to.

    Attributes
    ----------
    example : Example or None
        The smallest counterexample.
    claim, reason : str
        What it refutes, and why.
    tried : tuple of (str, str, int)
        Kind and class of examples, and how many were looked at.
    verified, doubtful, found_after, seconds
        As of an `Attack`; the seconds of a share without a counterexample are all of it.
    late : bool
        Whether time ended it.
    claims : tuple of (str, int)
        Claims, and how many examples each is about.
    """

    example: Any = None
    claim: str = ""
    reason: str = ""
    tried: tuple[tuple[str, str, int], ...] = ()
    verified: int = 0
    doubtful: int = 0
    found_after: int = 0
    seconds: float = 0.0
    late: bool = False
    claims: tuple[tuple[str, int], ...] = ()

    @property
    def is_last(self) -> bool:
        """Whether nothing is searched after it: it has found something, or a claim is about no example."""
        return self.example is not None or not self.tried

    @property
    def looked_at(self) -> int:
        """Number of examples."""
        return sum(count for *_, count in self.tried)


class Kept(NamedTuple):
    """The shares of a search in a folder: what is there was searched before, by the same code with the same options.

    Attributes
    ----------
    folder : Path or None
        None keeps nothing.
    form : str
        Of the examples.
    about, made_with : str
        What is searched; and all else that its result depends on, empty if that is not known.
    """

    folder: Path | None
    form: str
    about: str
    made_with: str

    def read(self) -> list[Share]:
        """Return the first shares, up to one that is not there."""
        found = list[Share]()
        while (share := self._read(self._file(len(found)))) is not None:
            found.append(share)
        return found

    def write(self, number: int, share: Share) -> None:
        """Keep a share, unless time ended it: another time, or another machine, has more."""
        if self.folder is not None and self.made_with and not share.late:
            require_writable(self.folder, "--out")
            with write_whole(self._file(number)) as file:
                file.write(msgspec.json.encode(share))

    def remembered(self) -> list[Any]:
        """Return what was found of the same claim by other code, or with other options."""
        if self.folder is None:
            return []
        own = f"{_hash(self.about)}-{_hash(self.made_with)}-"
        files = sorted(file for file in self.folder.glob(f"{_hash(self.about)}-*.json"))
        shares = [self._read(file) for file in files if not file.name.startswith(own)]
        return list(
            dict.fromkeys(share.example for share in shares if share is not None and share.example is not None)
        )

    def _file(self, number: int) -> Path:
        return (self.folder or Path()) / f"{_hash(self.about)}-{_hash(self.made_with)}-{number}.json"

    def _read(self, file: Path) -> Share | None:
        if self.folder is None:
            return None
        try:
            share = msgspec.json.decode(file.read_bytes(), type=Share)
            example = share.example and msgspec.convert(share.example, CLASSES[self.form])
        except (OSError, msgspec.MsgspecError):
            return None
        return replace(share, example=example)


def merged(shares: Sequence[Share]) -> Share:
    """Return what shares come to together: the last one may have found something."""
    *before, last = shares
    tried, claims = Counter[tuple[str, str]](), Counter[str]()
    for share in shares:
        tried.update({(kind, group): count for kind, group, count in share.tried})
        claims.update(dict(share.claims))
    return Share(
        last.example,
        last.claim,
        last.reason,
        tuple((*place, count) for place, count in sorted(tried.items())),
        sum(share.verified for share in shares),
        sum(share.doubtful for share in shares),
        sum(share.looked_at for share in before) + last.found_after if last.example is not None else 0,
        sum(share.seconds for share in shares),
        last.late,
        tuple(sorted(claims.items())),
    )


def _hash(text: str) -> str:
    return hashlib.blake2b(text.encode(), digest_size=8).hexdigest()
