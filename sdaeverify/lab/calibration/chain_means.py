"""Time averages along replicated chains: Student's interval from K independent chains."""

from dataclasses import dataclass

import numpy as np
import scipy

from ...arrays import Array
from ...contracts.calibrated import CalibrationCase
from ...contracts.matching import match
from ...contracts.scheme import Scheme
from ...contracts.specs import ProblemSpec
from ...errors import SchemeError
from ...noise.brownian import Source
from ...simulate.chains import Chains
from .many import opposite
from .rates import Rate, Trials
from .studies import COVERED

CHAINS = 16
# Steps a relaxation time, of the burn-in and of the record: about a thousand are recorded.
STEPS_A_TIME, BURN_IN, RECORD = 20, 10, 50


@dataclass(frozen=True)
class ChainJob:
    """All chains of a case; it can be pickled.

    Attributes
    ----------
    spec : ProblemSpec
    case : CalibrationCase
    scheme : Scheme
    seed : int
    repetitions : int
        Of `CHAINS` chains each, an even number.
    """

    spec: ProblemSpec
    case: CalibrationCase
    scheme: Scheme
    seed: int
    repetitions: int

    @property
    def label(self) -> str:
        """The problem's."""
        return self.spec.label

    def run(self) -> list[Rate]:
        """Return the coverage for each observable of the case."""
        view = match(self.scheme, self.spec.build()).problem
        if view is None:
            raise SchemeError(f"calibration of {self.case.label}: the scheme does not solve the problem")
        source = Source(self.seed, f"{self.spec.label}|calibration", 0, CHAINS * self.repetitions)
        chains = Chains(self.scheme, view, source, view.relaxation / STEPS_A_TIME)
        chains.advance(BURN_IN * STEPS_A_TIME)
        averages = chains.average(RECORD * STEPS_A_TIME)[0]
        rows = zip(view.observables, averages, strict=True)
        return [_rate(self.case, name, row.reshape(-1, CHAINS)) for name, row in rows if name in self.case.stationary]


def _rate(case: CalibrationCase, observable: str, averages: Array) -> Rate:
    means = averages.mean(axis=1)
    half = scipy.special.stdtrit(CHAINS - 1, 0.975) * averages.std(axis=1, ddof=1) / np.sqrt(CHAINS)
    truth = opposite(means[:, None], lambda mean: mean[0], len(means), len(means))
    trials = Trials("chains", f"{case.label}, {observable}")
    return trials.rate(
        f"interval of the stationary mean from {CHAINS} chains, 95 %", abs(means - truth) <= half, COVERED
    )
