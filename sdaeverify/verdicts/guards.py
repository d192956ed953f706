"""All guards in the order in which they apply: to one step, to paths, to the problem and to the run.

Each entry names the cell of `tests/guard_cells.py` that is judged wrongly without it. `reports/ablate.py` takes the
guards out one at a time and judges these cells again; the site shows its table.
"""

from ..contracts.finding import ONE_STEP, SAMPLED
from ..measures.path_errors.order import Fit, seems_early, why_coarse, why_on_its_way
from ..measures.strong.findings import is_changing
from ..measures.weak import grows, is_coarse_mean, shrinks, turns
from ..measures.weak.probe import of_mesh, unless_taken_back
from ..probe.local.smoothness import smoothness
from ..probe.local.strong_order import converges_later
from ..probe.local.weak_order import WeakOrder
from . import rules
from .guard import DECIDE, REFUTE, VERIFY, Guard
from .opinions import doubt_few_paths, doubt_likeness, doubt_power, is_suspect, of_law, of_memory, of_smooth
from .path_tests import PathTests, hold_back, resolve_order, why_lost, why_vacuous, with_sample

OF_ONE_STEP = (
    Guard(
        asks=of_smooth,
        bars=DECIDE,
        tier=ONE_STEP,
        reason="a coefficient is not smooth enough for a local order to be the order of a run",
        remedy="paths with a truth",
        planted="SRA1 with a kink in the drift",
    ),
    Guard(
        asks=of_law,
        bars=VERIFY,
        tier=ONE_STEP,
        reason="increments are clipped, which nodes of the normal law do not show",
        remedy="a larger p of the clipping",
        planted="Milstein with clipped increments",
    ),
    Guard(
        asks=of_mesh,
        bars=VERIFY,
        tier=ONE_STEP,
        reason="lagged values are interpolated, which one step with an exact history does not show",
        remedy="a delay of whole steps",
        planted="trapezoidal rule with a lag between mesh points",
    ),
    Guard(
        asks=of_memory,
        bars=DECIDE,
        tier=ONE_STEP,
        reason="the memory of a run changes it by more than the claimed order allows",
        remedy="paths",
        planted="Heun with a drift of every second step",
    ),
    Guard(
        asks=smoothness,
        bars=VERIFY,
        tier=ONE_STEP,
        reason="the observable has a jump or a kink, and one step decides smooth functions only",
        remedy="a law on few points",
        planted="three-point increments and a digital observable",
    ),
    Guard(
        asks=is_changing,
        bars=REFUTE,
        tier=ONE_STEP,
        reason="the local order still changes with the step size",
        remedy="shorter steps",
        planted="balanced Euler on a stiff fibre",
    ),
    Guard(
        asks=unless_taken_back,
        bars=REFUTE,
        tier=ONE_STEP,
        reason="the scheme declares that later steps take errors of single steps back",
        remedy="paths, or moment equations",
        planted="explicit and implicit Euler in turns",
    ),
    Guard(
        asks=converges_later,
        bars=DECIDE,
        tier=ONE_STEP,
        reason="a step has an order at much shorter step sizes only, as taming does",
        remedy="shorter steps than a run has",
        planted="balanced Euler in slow time, along paths",
    ),
    Guard(
        asks=WeakOrder.rises,
        bars=DECIDE,
        tier=ONE_STEP,
        reason="the local weak order rises at much shorter step sizes",
        remedy="shorter steps than a run has",
        planted="balanced Euler in slow time, in law",
    ),
)
OF_PATHS = (
    Guard(
        asks=with_sample,
        bars=DECIDE,
        tier=SAMPLED,
        reason="the sample is too small for the level of the test, or its tails are heavy",
        remedy="more paths",
        planted="balanced Euler with a strong pull, 40 paths",
    ),
    Guard(
        asks=resolve_order,
        bars=VERIFY,
        tier=SAMPLED,
        reason="a term of half an order less may be a tenth of the error at the finest step",
        remedy="finer steps",
        planted="Milstein with 0.96 of its integral",
    ),
    Guard(
        asks=PathTests.without_truth,
        bars=VERIFY,
        tier=SAMPLED,
        reason="errors are measured against the scheme's own finest steps",
        remedy="a truth",
        planted="one Newton iteration with a delay",
    ),
    Guard(
        asks=why_vacuous,
        bars=VERIFY,
        tier=SAMPLED,
        reason="the claimed bound is no less than the size of the quantity",
        remedy="a smaller bound",
        planted="a bound of 100 for a bias",
    ),
    Guard(
        asks=Fit.rises.fget,  # type: ignore[attr-defined]
        bars=REFUTE,
        tier=SAMPLED,
        reason="the order along paths still rises with refinement",
        remedy="finer steps",
        planted="Milstein on growth that falls fast",
    ),
    Guard(
        asks=seems_early,
        bars=REFUTE,
        tier=SAMPLED,
        reason="errors fall like their differences on the finest steps, as they do not towards a wrong limit",
        remedy="finer steps",
        planted="balanced Euler on a stiff fibre",
    ),
    Guard(
        asks=turns,
        bars=REFUTE,
        tier=SAMPLED,
        reason="mean differences grow up to some step size and fall from there on",
        remedy="finer steps",
        planted="balanced Euler on the orthogonal group",
    ),
    Guard(
        asks=hold_back,
        bars=REFUTE,
        tier=SAMPLED,
        reason="steps do not resolve the fastest time of the problem",
        remedy="finer steps",
        planted="Heun with noise that oscillates within a step",
    ),
    Guard(
        asks=why_lost,
        bars=REFUTE,
        tier=SAMPLED,
        reason="paths are lost at step sizes hardly longer than those that are fitted",
        remedy="finer steps",
        planted="balanced Euler on a loud double well",
    ),
    Guard(
        asks=why_coarse,
        bars=REFUTE,
        tier=SAMPLED,
        reason="the error of a component is a quarter of its motion, and still changes as h is halved",
        remedy="finer steps",
        planted="tamed Euler on fast growth",
    ),
    Guard(
        asks=why_on_its_way,
        bars=REFUTE,
        tier=SAMPLED,
        reason="the order is as claimed at the next step size if it rises once more as it did last",
        remedy="finer steps",
        planted="balanced Euler with a growing volatility",
    ),
    Guard(
        asks=is_coarse_mean,
        bars=REFUTE,
        tier=SAMPLED,
        reason="the error of a mean is a quarter of the mean",
        remedy="finer steps",
        planted="tamed Euler on growth, in law",
    ),
    Guard(
        asks=grows,
        bars=DECIDE,
        tier=SAMPLED,
        reason="mean differences do not fall yet",
        remedy="finer steps",
        planted="tamed Euler and means that grow fast",
    ),
    Guard(
        asks=shrinks,
        bars=VERIFY,
        tier=SAMPLED,
        reason="the finest mean difference is larger than all others",
        remedy="finer steps",
        planted="Euler-Maruyama with the truth of slower growth",
    ),
    Guard(
        asks=is_suspect,
        bars=VERIFY,
        tier=SAMPLED,
        reason="the same paths speak against the claim",
        remedy="finer steps",
        planted="errors of a rate of 1/2 with a mean that stays",
    ),
    Guard(
        asks=doubt_few_paths,
        bars=VERIFY,
        tier=ONE_STEP,
        reason="too few paths for an interval guard what one step says",
        remedy="100 paths",
        planted="another noise, 64 paths",
    ),
    Guard(
        asks=doubt_likeness,
        bars=VERIFY,
        tier=ONE_STEP,
        reason="paths do not show what is claimed at the step sizes of the run",
        remedy="more paths, or finer steps",
        planted="another noise, 128 paths",
    ),
    Guard(
        asks=doubt_power,
        bars=VERIFY,
        tier=ONE_STEP,
        reason="the paths would not show an error as large as the claim forbids",
        remedy="more paths",
        planted="another noise and heavy tails, 128 paths",
    ),
)
OF_CELLS = (
    Guard(
        asks=rules.withhold_in_doubt,
        bars=VERIFY,
        tier=None,
        reason="another quantity of the same cell tends to a wrong limit",
        remedy="",
        planted="a projection with a wrong Coriolis term",
    ),
)
OF_RUNS = tuple(rule for rule in rules.RULES if isinstance(rule, Guard))
GUARDS: tuple[Guard, ...] = (*OF_ONE_STEP, *OF_PATHS, *OF_CELLS, *OF_RUNS)
