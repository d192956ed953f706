"""From paths to verdicts over many seeds: no true order is refuted, and half an order more is never verified."""

from collections.abc import Iterator

import pytest

from facade import (
    Calibration,
    Processes,
    Rate,
    Strong,
    Study,
    available_cores,
    calibration_plan,
    load_registry,
    plan,
    select_problems,
    select_schemes,
    with_claims,
)
from sdaeverify import Claim, Settings
from sdaeverify.measuring import Tally, Verdict

# A case with half a share has this many sequences, the others twice as many.
SEQUENCES = 200
SEEDS = 10
REGISTRY = load_registry(lab=True)
CASES = [case for case in REGISTRY.things("sdaeverify_calibration").values() if case.strong]


class PathsAlone(Strong):
    """The strong measure without local orders."""

    def probe(self, scheme, view, settings):
        """Return nothing."""
        return Tally()


def verdicts(case, above: float, measure: Strong) -> Iterator[list[Verdict]]:
    """Yield for each seed the verdicts on the claim that the order of a case is so much above the true one."""
    claim = Claim(measure="strong", value=case.order + above, source="test")
    scheme = with_claims(select_schemes(REGISTRY, [case.scheme])[0], claim)
    made = plan(
        [scheme],
        select_problems(REGISTRY, [case.problem]),
        [measure],
        lambda label: select_schemes(REGISTRY, label)[0],
    )
    for seed in range(SEEDS):
        study = Study(made, Settings(seed=seed))
        for _ in study.run():
            pass
        yield [finding.verdict for result in study.results() for finding in result.findings]


@pytest.fixture(scope="module")
def rates() -> list[Rate]:
    """Return the rates of verdicts of the strong measure on at least 200 sequences of up to 1600 paths a case."""
    smallest = min(case.share for case in CASES)
    calibration = Calibration(
        calibration_plan(REGISTRY, Settings().seed, round(4 * SEQUENCES / smallest), ["verdicts"])
    )
    with Processes(available_cores()) as executor:
        for _ in calibration.run(executor):
            pass
    return calibration.rates


@pytest.mark.slow
def test_no_wrong_verdict_in_hundreds_of_sequences(rates):
    """On 200 seeds a case and more no true order is refuted and none too high is verified."""
    wrong = [rate for rate in rates if rate.expected.high < 1.0]

    assert len(wrong) == 4 * len(CASES)
    assert min(rate.trials for rate in wrong) >= SEQUENCES
    assert not [rate for rate in wrong if rate.hits]


@pytest.mark.slow
def test_local_orders_decide_every_sequence(rates):
    """With local orders every true order is verified and every higher one refuted, whatever the tails."""
    right = [rate for rate in rates if rate.expected.high == 1.0 and rate.statistic.endswith("with local orders")]

    decided = [r for r in right if r.statistic.startswith(("true order verified", "order + 0.5 refuted"))]
    assert len(decided) == 2 * len(CASES)
    assert all(rate.hits == rate.trials for rate in decided)


@pytest.mark.slow
@pytest.mark.parametrize("measure", [Strong(), PathsAlone()], ids=["with local orders", "paths alone"])
@pytest.mark.parametrize("case", CASES, ids=lambda case: case.label)
def test_no_wrong_verdict_in_whole_runs(case, measure):
    """Over ten seeds of whole runs with their controls and corrections no verdict is wrong."""
    kept, broken = ([found for seed in verdicts(case, above, measure) for found in seed] for above in (0.0, 0.5))

    assert set(kept) <= {Verdict.VERIFIED, Verdict.INCONCLUSIVE}
    assert set(broken) <= {Verdict.REFUTED, Verdict.INCONCLUSIVE}
    # Silence would be no proof: most runs with local orders must say something.
    if type(measure) is Strong:
        assert Verdict.VERIFIED in kept
        assert Verdict.REFUTED in broken
