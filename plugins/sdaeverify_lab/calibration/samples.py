"""Jobs of the calibration: blocks of repetitions along paths, and time averages along replicated chains.

Paths are simulated by the ensemble of ordinary runs. A time average has Student's interval from K independent chains.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
import scipy

from sdaeverify import Array, Scheme, SchemeError, Settings
from sdaeverify.measuring import Measure, Tally
from sdaeverify.studying import Chains, Entry, ProblemSpec, SchemeEvidence, Source, Task, match, run_block

from ..cases import CalibrationCase
from .judged import JudgedSequences, judge_sequences
from .rates import COVERED, Rate, Trials
from .repeated import POOLED, UNIT, Repeated, append_tallies, opposite

SEQUENCE = UNIT * POOLED
SEQUENCES_A_BLOCK = 4
# Parts of names of quantities: the full state, and the final time.
STATE, AT_END = "state", "@T"


class Sample(NamedTuple):
    """Repetitions of UNIT paths of a case; POOLED adjacent ones form a sequence of independent looks.

    Attributes
    ----------
    case : CalibrationCase
    h : ndarray, shape (L,)
        Step sizes.
    strong : Tally
        Stacked tally: ``error`` and ``difference`` of the full state at T, ``paths``.
    weak : Tally
        Stacked tally: ``values`` of the observables.
    judged : JudgedSequences or None
        Results of the strong measure on each sequence.
    """

    case: CalibrationCase
    h: Array
    strong: Tally
    weak: Tally
    judged: JudgedSequences | None

    @property
    def sequences(self) -> int:
        """Number of sequences."""
        return len(self.strong.sums["paths"]) // POOLED

    @property
    def errors(self) -> Array:
        """Sums of e^p over groups, p = 1/2, 1, 2, shape (R, G, L, 3)."""
        (name,) = (name for name in self.strong.sums if name.startswith("error "))
        return self.strong.sums[name]


@dataclass(frozen=True)
class PathJob:
    """One block of repetitions for all cases of a problem, which can be pickled.

    Attributes
    ----------
    spec : ProblemSpec
    cases : tuple of (CalibrationCase, Scheme)
    settings : Settings
    block : int
    measures : tuple of Measure
        Measures of errors along paths, and of expectations.
    judged : bool
        Whether the first measure also judges the sequences.
    """

    spec: ProblemSpec
    cases: tuple[tuple[CalibrationCase, Scheme], ...]
    settings: Settings
    block: int
    measures: tuple[Measure, ...]
    judged: bool

    @property
    def label(self) -> str:
        """Label of the problem."""
        return self.spec.label

    def run(self) -> list[Sample]:
        """Return the samples of the cases."""
        measures = tuple(map(Repeated, self.measures))
        task = Task(self.spec, tuple(Entry(scheme, measures) for _, scheme in self.cases), self.settings)
        lanes = run_block(task, self.block)
        return [self._sample(*case, lane) for case, lane in zip(self.cases, lanes, strict=True)]

    def _sample(self, case: CalibrationCase, scheme: Scheme, lane: SchemeEvidence) -> Sample:
        if reason := "; ".join(filter(None, [*lane.errors, lane.violation])):
            raise SchemeError(f"calibration of {case.label}: {reason}")
        problem = self.spec.build()
        strong, weak = of_state(lane.tallies[0]), lane.tallies[1]
        judged = None
        if self.judged:
            judged = judge_sequences(case, (scheme, problem), self.measures[0], (strong, lane.health))
        kept = Tally({name: sums for name, sums in strong.sums.items() if not name.startswith("blurred ")})
        return Sample(case, problem.horizon / np.array(self.settings.steps), kept, weak, judged)


def path_settings(seed: int, sequences: int) -> tuple[Settings, list[int]]:
    """Return settings with at least the given number of sequences in full blocks, and the indices of these blocks."""
    size = SEQUENCE * SEQUENCES_A_BLOCK
    blocks = -(-sequences // SEQUENCES_A_BLOCK)
    settings = Settings(paths=(blocks + 2) * size, block=size, seed=seed)
    full = [index for index, paths in enumerate(settings.sizes) if paths == size == settings.paths_of(index)]
    return settings, full[:blocks]


def join_samples(samples: Sequence[Sample]) -> Sample:
    """Concatenate the samples of several blocks."""
    judged = [sample.judged for sample in samples if sample.judged is not None]
    return samples[0]._replace(
        strong=append_tallies([sample.strong for sample in samples]),
        weak=append_tallies([sample.weak for sample in samples]),
        judged=JudgedSequences(*map(np.concatenate, zip(*judged, strict=True))) if judged else None,
    )


def of_state(tally: Tally) -> Tally:
    """Return the part of the strong measure's tally on the full state at T."""
    names = {name.partition(" ")[2] for name in tally.sums} - {""}
    quantity = STATE + AT_END if STATE + AT_END in names else next(name for name in names if name.endswith(AT_END))
    about = {quantity, quantity.removesuffix(AT_END)}
    return Tally(
        {name: value for name, value in tally.sums.items() if name.partition(" ")[2] in {quantity, ""}},
        {name: value for name, value in tally.maxima.items() if name.partition(" ")[2] in about},
        {name: value for name, value in tally.largest.items() if name == quantity},
    )


CHAINS = 16
# Steps per relaxation time; burn-in and record in relaxation times: about a thousand steps are recorded.
STEPS_A_TIME, BURN_IN, RECORD = 20, 10, 50


@dataclass(frozen=True)
class ChainJob:
    """All chains of a case, which can be pickled.

    Attributes
    ----------
    spec : ProblemSpec
    case : CalibrationCase
    scheme : Scheme
    seed : int
    repetitions : int
        Number of repetitions with `CHAINS` chains each, even.
    """

    spec: ProblemSpec
    case: CalibrationCase
    scheme: Scheme
    seed: int
    repetitions: int

    @property
    def label(self) -> str:
        """Label of the problem."""
        return self.spec.label

    def run(self) -> list[Rate]:
        """Return the coverage for each observable of the case."""
        view = match(self.scheme, self.spec.build()).problem
        if view is None:
            raise SchemeError(f"calibration of {self.case.label}: the scheme does not solve the problem")
        source = Source(self.seed, f"{self.spec.label}|calibration", 0, CHAINS * self.repetitions)
        chains = Chains(self.scheme, view, source, view.relaxation_time / STEPS_A_TIME)
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
