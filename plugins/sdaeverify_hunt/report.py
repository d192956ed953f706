"""Report of a hunt: tried examples, counterexamples, and their description in sentences."""

from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field
from pathlib import Path

from sdaeverify import UsageError
from sdaeverify.commands import write_text

from .strategies.example import NAME, Example

# Defect of an order that one step can detect, by the tolerance with which claims are judged.
RESOLUTION = "an order below the claim by {tolerance:g} or more at some of the examined states"
UNSEEN = "The scheme claims nothing on the drawn problems, or it raises on them (see sdaeverify check)."
TEST = '''"""Claims that a hunt refuted: they fail until the scheme is corrected."""

from pathlib import Path

import pytest

import sdaeverify

PLUGINS = [Path(__file__).with_name("{plugin}"), *{plugins}]


@pytest.mark.parametrize(("scheme", "measure"), {cells})
def test_counterexample_is_not_refuted(scheme, measure):
    """The scheme keeps its claim on the problem that was found."""
    found = sdaeverify.verify(scheme, "{name}", measure, plugins=PLUGINS).verdicts

    assert len(found)
    assert not (found.verdict == "refuted").any()
'''


def counted(number: int, word: str) -> str:
    """Return a number with a word in the singular or plural."""
    return f"{number} {word}{'' if number == 1 else 's'}"


@dataclass(frozen=True)
class Attack:
    """Result of the attack on one claim by examples of one form.

    Attributes
    ----------
    scheme, measure, form : str
    claim : str
        Refuted claim; empty if none was refuted.
    example : Example or None
        The smallest counterexample.
    reason : str
        Why the example refutes the claim.
    confirmed : bool
        Whether `sdaeverify.verify` refutes the claim on the example's plugin file as well.
    by_paths : str
        Verdict of paths alone there, or why there is none.
    tried : mapping of (str, str) to int
        Number of examined examples, by kind and class.
    claims : mapping of str to int
        Number of examples in the scope of each claim, since a scheme may claim more on some problems.
    verified, doubtful : int
        Number of examples that verify the claim, and that refuted it once but not again.
    found_after, seconds : int, float
        Number of examples and seconds until the first counterexample.
    tolerance : float
        Tolerance of an order below its claim; NaN if no order was estimated.
    """

    scheme: str
    measure: str
    form: str
    claim: str = ""
    example: Example | None = None
    reason: str = ""
    confirmed: bool = False
    by_paths: str = ""
    tried: Mapping[tuple[str, str], int] = field(default_factory=dict)
    claims: Mapping[str, int] = field(default_factory=dict)
    verified: int = 0
    doubtful: int = 0
    found_after: int = 0
    seconds: float = 0.0
    tolerance: float = float("nan")

    @property
    def looked_at(self) -> int:
        """Number of examined examples."""
        return sum(self.tried.values())

    @property
    def outcome(self) -> str:
        """Result in a sentence."""
        what = f"{self.scheme}, {self.measure}, {self.form}"
        if not self.tried:
            return f"{what}: no example was examined. {UNSEEN}"
        if self.example is None:
            return f"{what}: nothing found in {counted(self.looked_at, 'example')}. {self._worth()}"
        size = f"a dimension of {self.example.dimension} and a number of terms of {self.example.terms}"
        sure = (
            f"confirmed (paths alone: {self.by_paths})"
            if self.confirmed
            else "not confirmed by a run, and therefore not counted"
        )
        begun = f"refuted by example {self.found_after} after {self.seconds:.1f} s"
        return f"{what}: {self.claim} is {begun}, shrunk to {size}, {sure}. {self.reason}"

    def _worth(self) -> str:
        left = self.looked_at - self.verified
        doubt = f", {self.doubtful} of which refuted the claim once but not on repetition" if self.doubtful else ""
        told = f"All claims are verified on {self.verified}, undecided on {left}{doubt}"
        if self.tolerance != self.tolerance:
            return f"{told}."
        return f"{told}. Detectable: {RESOLUTION.format(tolerance=self.tolerance)}."

    @property
    def claimed(self) -> str:
        """Number of examples of each claim, in words."""
        return "; ".join(f"{count} of {claim}" for claim, count in sorted(self.claims.items()))

    @property
    def classes(self) -> str:
        """Number of examined examples by kind and class, in words."""
        return "; ".join(f"{count} of {kind}, {group}" for (kind, group), count in sorted(self.tried.items()))


@dataclass(frozen=True, repr=False)
class HuntReport:
    """Result of a hunt.

    Attributes
    ----------
    attacks : tuple of Attack
        One attack for each scheme, measure and form.
    plugins : tuple of str
        Plugin files of the schemes.
    """

    attacks: tuple[Attack, ...]
    plugins: tuple[str, ...] = ()

    @property
    def found(self) -> tuple[Attack, ...]:
        """Attacks with a confirmed counterexample."""
        return tuple(attack for attack in self.attacks if attack.example is not None and attack.confirmed)

    @property
    def looked_at(self) -> int:
        """Number of examined examples."""
        return sum(attack.looked_at for attack in self.attacks)

    @property
    def summary(self) -> str:
        """Number of examples and of refuted claims, in words."""
        return f"{counted(self.looked_at, 'example')}, {counted(len(self.found), 'claim')} refuted"

    def sentences(self) -> Iterator[str]:
        """Yield the result for each claim, the tried examples, and the total counts."""
        for attack in self.attacks:
            yield attack.outcome
            if attack.tried:
                yield f"  claims: {attack.claimed}"
                yield f"  tried: {attack.classes}"
        numbers = {"example": self.looked_at, "attack": len(self.attacks), "counterexample": len(self.found)}
        yield f"{', '.join(counted(number, word) for word, number in numbers.items())}."

    def write(self, path: str | Path) -> tuple[Path, ...]:
        """Write the first confirmed counterexample as a plugin file, and a test for it; return both files.

        Raises
        ------
        UsageError
            If the file does not end in .py or cannot be written.
        """
        file = Path(path)
        if file.suffix != ".py":
            raise UsageError(f"a plugin file ends in .py, got {str(path)!r:.200}")
        if not self.found:
            return ()
        first = self.found[0]
        assert first.example is not None
        cells = [(first.scheme, first.measure)]
        test = file.with_name(f"test_{file.name}")
        write_text(first.example.source, file)
        write_text(TEST.format(plugin=file.name, plugins=list(self.plugins), cells=cells, name=NAME), test)
        return file, test

    def __repr__(self) -> str:
        return "\n".join(self.sentences())
