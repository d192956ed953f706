"""Shares of a search with a fixed number of examples: budget, result and storage."""

import hashlib
from collections import Counter
from collections.abc import Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any, NamedTuple

import msgspec

from sdaeverify.commands import require_writable, write_text

from .strategies.forms import CLASSES

# Examples of a share. Each share has a seed, so that its result does not depend on worker and time.
SIZE = 50


class Budget(NamedTuple):
    """Budget of a share.

    Attributes
    ----------
    examples : int
        Number of draws; an example drawn twice is examined once.
    seconds : float
        Time in seconds until the first counterexample.
    shrinking : float
        Time in seconds for shrinking.
    """

    examples: int = SIZE
    seconds: float = float("inf")
    shrinking: float = 60.0


@dataclass(frozen=True)
class Share:
    """Result of the search of one share.

    Attributes
    ----------
    example : Example or None
        Smallest counterexample.
    claim, reason : str
        Refuted claim, and the reason.
    tried : tuple of (str, str, int)
        Kind, class and number of examined examples.
    verified, doubtful, found_after, seconds
        As in `Attack`; without a counterexample, `seconds` is the duration of the share.
    late : bool
        Whether a time limit ended the share.
    claims : tuple of (str, int)
        Claims, and the number of examples in the scope of each.
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
        """Whether the search ends with this share: it has a counterexample, or no example in the scope of a claim."""
        return self.example is not None or not self.tried

    @property
    def looked_at(self) -> int:
        """Number of examined examples."""
        return sum(count for *_, count in self.tried)


class StoredShares(NamedTuple):
    """Stored shares of a search, made by the same code with the same options.

    Attributes
    ----------
    folder : Path or None
        Folder of the shares; None to store none.
    form : str
        Form of the examples.
    about, made_with : str
        Target of the search, and a hash of all other inputs of its result, empty if unknown.
    """

    folder: Path | None
    form: str
    about: str
    made_with: str

    def read(self) -> list[Share]:
        """Return the stored shares from number 0 up to the first missing one."""
        found = list[Share]()
        while (share := self._read(self._file(len(found)))) is not None:
            found.append(share)
        return found

    def write(self, number: int, share: Share) -> None:
        """Store a share, unless a time limit ended it, since it would depend on the speed of the machine."""
        if self.folder is not None and self.made_with and not share.late:
            require_writable(self.folder, "--out")
            write_text(msgspec.json.encode(share).decode(), self._file(number))

    def remembered(self) -> list[Any]:
        """Return counterexamples to the same claim found with other code or other options."""
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
    """Merge shares; only the last one may have a counterexample."""
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
