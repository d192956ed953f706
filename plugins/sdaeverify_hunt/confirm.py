"""Confirmation of a counterexample, by a run on its plugin file and by paths alone."""

from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any

from sdaeverify import Scheme, verify
from sdaeverify.measuring import Measure, Tally, Verdict

from .strategies.example import NAME, Example

# Tier of the contract of a step, and the text about paths if the contract is broken.
CONTRACT_TIER, BROKEN = "T0", "not sampled, because the check of the contract refutes the step"
# Probability of a false alarm, shared by all confirmations of a hunt.
CHANCE = 0.01


def confirm(scheme: Scheme, example: Example, measure: Measure, found: int) -> tuple[bool, str]:
    """Return whether a run refutes a claim on an example, and the verdict of paths without single steps.

    A claim that paths alone verify does not count as refuted, even if one step refutes it.

    Parameters
    ----------
    scheme : Scheme
    example : Example
    measure : Measure
    found : int
        Number of counterexamples to confirm; the confidence is 1 - 1/100/found.
    """
    confidence = 1.0 - CHANCE / max(found, 1)
    with TemporaryDirectory() as folder:
        file = Path(folder) / f"{NAME}.py"
        file.write_text(example.source, encoding="utf-8")

        def rows(of: Measure) -> Any:
            table = verify([scheme], NAME, [of], plugins=[file], confidence=confidence).verdicts
            return table[table.scheme == scheme.label]

        whole, paths = rows(measure), rows(_unprobed(measure))
    refuted = str(Verdict.REFUTED) in set(whole["verdict"])
    if (whole["decided_by"] == CONTRACT_TIER).any():
        # The contract is checked before paths are simulated, mostly on trivial equations.
        return refuted, BROKEN
    alone = _verdict_of(set(paths["verdict"]))
    return refuted and alone is not Verdict.VERIFIED, str(alone)


def _verdict_of(verdicts: set[str]) -> Verdict:
    """Return the verdict on a claim from those on its quantities."""
    if str(Verdict.REFUTED) in verdicts:
        return Verdict.REFUTED
    return Verdict.VERIFIED if verdicts == {str(Verdict.VERIFIED)} else Verdict.INCONCLUSIVE


def _unprobed(measure: Measure) -> Measure:
    """Return the measure without its evidence from single steps."""

    def probe(*_: object) -> Tally:
        return Tally()

    kind: type[Measure] = type(f"Unprobed{type(measure).__name__}", (type(measure),), {"probe": probe})
    return kind()
