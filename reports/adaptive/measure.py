"""Measures what the verifier of adaptive solvers is worth, and writes the figures into this folder.

`python reports/adaptive/measure.py` makes all of them, `python reports/adaptive/measure.py law work` those that are
named. Each leaves a table, `NAME.csv`; `README.md` is written from all that are there.
"""

import sys
import time
from collections.abc import Callable, Iterator
from concurrent.futures import ProcessPoolExecutor
from itertools import product
from multiprocessing import get_context
from pathlib import Path

import numpy as np
import pandas as pd

from sdaeverify.commands import load_and_warn
from sdaeverify.measuring import Verdict
from sdaeverify.studying import Registry, Source, one_thread, select_problems
from sdaeverify_adaptive import TICKS, brownian_path
from sdaeverify_adaptive.checks import check
from sdaeverify_adaptive.judging import Question, ask
from sdaeverify_adaptive.path import GRID, PER_STEP
from sdaeverify_adaptive.sample import Budget, Sample, fixed, measure, truth
from sdaeverify_solvers import judge

FOLDER = Path(__file__).parent
GBM, MILD = "gbm[a=0.1,b=0.8]", "gbm[a=0.1,b=0.3]"
RIGHT = [
    *((name, label) for name in ("euler-previsible", "heun-nested") for label in (GBM, "ou", "heisenberg", "shear")),
    *((name, label) for name in ("heun-pi", "milstein-pi") for label in (GBM, "ou")),
]
WRONG = [
    ("planted-blind", "ou"),
    ("planted-floor", "ou"),
    ("planted-peek", MILD),
    ("planted-redraw", "ou"),
    ("planted-redraw-law", "ou"),
    ("planted-skip", "heisenberg"),
    ("planted-skip-mixed", "shear"),
]
CHECKED = [("planted-batch-norm", "own steps"), ("planted-wide-bridge", "keeps its path")]
PATHS = 400
WORKERS = 2
SEEDS_OF_RIGHT, SEEDS_OF_WRONG = range(1, 18), range(1, 21)


def sampled(registry: Registry, name: str, label: str, seed: int) -> tuple[Sample, float]:
    """Return a sample of a solver, and the seconds that it took."""
    problem, begun = select_problems(registry, label)[0].build(), time.process_time()
    return measure(registry.things("sdaeverify_adaptive")[name], problem, Budget(PATHS, (), seed), label), (
        time.process_time() - begun
    )


def judged(registry: Registry, pair: tuple[str, str], seed: int) -> Iterator[dict[str, object]]:
    """Yield a row for each claim of a solver, which is judged alone, with the limit and without it."""
    name, label = pair
    sample, seconds = sampled(registry, name, label, seed)
    asked, without = ([*ask(Question(sample, with_limit))] for with_limit in (True, False))
    rows = zip(asked, judge(asked), judge(without), strict=True)
    for one, found, blind in rows:
        yield {
            "solver": name,
            "problem": label,
            "seed": seed,
            "measure": one.measure,
            "quantity": found.quantity,
            "verdict": found.verdict.value,
            "without_limit": blind.verdict.value,
            "estimate": found.estimate,
            "low": found.low,
            "high": found.high,
            "p_refuted": found.p_refuted,
            "resolution": found.resolution,
            "mean_steps": float(sample.runs.steps[-1].mean()),
            "seconds": seconds,
        }


def rows_of(job: tuple[tuple[str, str], int]) -> list[dict[str, object]]:
    """Return the rows of a solver on a problem and of a seed, in a worker of its own."""
    with one_thread():
        return [*judged(load_and_warn((), lab=True), *job)]


def on_workers(pairs: list[tuple[str, str]], seeds: range) -> Iterator[dict[str, object]]:
    """Yield the rows of all pairs and seeds."""
    with ProcessPoolExecutor(WORKERS, mp_context=get_context("spawn")) as pool:
        # All pairs of one seed come before the next seed: what is there of a run that was broken off is balanced.
        for rows in pool.map(rows_of, [(pair, seed) for seed, pair in product(seeds, pairs)]):
            yield from rows


def right(_: Registry) -> Iterator[dict[str, object]]:
    """Yield the verdicts on right solvers."""
    yield from on_workers(RIGHT, SEEDS_OF_RIGHT)


def wrong(_: Registry) -> Iterator[dict[str, object]]:
    """Yield the verdicts on planted solvers."""
    yield from on_workers(WRONG, SEEDS_OF_WRONG)


def checks(registry: Registry) -> Iterator[dict[str, object]]:
    """Yield what the checks find of planted solvers, and of right ones."""
    pairs = [(name, label, "") for name, label in RIGHT] + [(name, GBM, which) for name, which in CHECKED]
    for name, label, which in pairs:
        solver, problem = registry.things("sdaeverify_adaptive")[name], select_problems(registry, label)[0].build()
        for seed in SEEDS_OF_WRONG:
            path = brownian_path(Source(seed, label, 0, 20), problem.noise_dim, problem.horizon)
            failed = sorted(answer.check for answer in check(solver, problem, path, 2.0**-8) if answer.failed)
            told = {"expected": which, "failed": " ".join(failed)}
            yield {"solver": name, "problem": label, "seed": seed, **told}


def law(_: Registry) -> Iterator[dict[str, object]]:
    """Yield the law of increments over one tick inside the steps of the grid."""
    blocks = [brownian_path(Source(7, "law", block, 4000), 1, 1.0) for block in range(5)]
    begin = np.random.default_rng(3).integers(0, GRID, 4000) * PER_STEP + 1
    a, b, c = (np.concatenate([each.at(begin + step).W[0] for each in blocks]) for step in (0, 1, 2))
    first, second = np.sqrt(TICKS) * (b - a), np.sqrt(TICKS) * (c - b)
    n = len(first)
    yield {"what": "variance over a tick", "value": float(np.mean(first**2)), "std_error": (2.0 / n) ** 0.5}
    yield {"what": "correlation of neighbours", "value": float(np.mean(first * second)), "std_error": n**-0.5}


def work(registry: Registry) -> Iterator[dict[str, object]]:
    """Yield errors and costs of adaptive solvers and of fixed steps, on the same paths."""
    solvers = {"heun": "heun-pi", "milstein": "milstein-pi", "euler-maruyama": "euler-previsible"}
    for label in (GBM, "ou"):
        problem = select_problems(registry, label)[0].build()
        path = next(brownian_path(source, problem.noise_dim, 1.0) for source in Budget(PATHS, (), 1).sources(label))
        exact = truth(problem, path)
        for scheme, name in solvers.items():
            sample, _ = sampled(registry, name, label, 1)
            for k, tolerance in enumerate(sample.budget.tolerances):
                tries = float(sample.tries[k].mean())
                yield row_of_work(label, name, sample.errors[k], tries, tolerance)
            for steps in (16, 64, 256, 1024):
                ends = fixed(registry.schemes[scheme].thing, problem, path, steps)
                yield row_of_work(label, f"{scheme}, fixed steps", ends - exact, float(steps))


def row_of_work(
    label: str, name: str, errors: np.ndarray, tries: float, tolerance: float = np.nan
) -> dict[str, object]:
    """Return a row: rms, median and the worst hundredth of the errors, beside the mean number of tries."""
    sizes = np.sqrt((errors**2).sum(axis=0))
    rms, median, worst = np.sqrt(np.mean(sizes**2)), np.median(sizes), np.quantile(sizes, 0.99)
    found = {"rms": float(rms), "median": float(median), "worst_hundredth": float(worst)}
    return {"problem": label, "solver": name, "tolerance": tolerance, "tries": tries, **found}


TABLES: dict[str, Callable[[Registry], Iterator[dict[str, object]]]] = {
    "law": law,
    "checks": checks,
    "work": work,
    "wrong": wrong,
    "right": right,
}


def verdict_lines(rows: pd.DataFrame, wanted: str) -> Iterator[str]:
    """Yield a line for each solver and problem: runs, those refuted, and what was found of the rate."""
    yield from ("", f"| solver | problem | runs | refuted | {wanted} | rate found | CPU seconds a run |")
    yield "|---|---|---|---|---|---|---|"
    for (name, label), cell in rows.groupby(["solver", "problem"]):
        runs = cell.groupby("seed")
        refuted = int((runs["verdict"].agg(lambda each: Verdict.REFUTED in set(each))).sum())
        other = int((runs["without_limit"].agg(lambda each: Verdict.REFUTED in set(each))).sum())
        verified = int((runs["verdict"].agg(lambda each: set(each) == {Verdict.VERIFIED})).sum())
        rates = cell[cell["measure"] == "tolerance"]
        first = (cell if rates.empty else rates)["estimate"]
        shown = verified if wanted == "all verified" else other
        found, seconds = f"{first.min():.2f} to {first.max():.2f}", runs["seconds"].first().mean()
        yield f"| {name} | {label} | {len(runs)} | {refuted} | {shown} | {found} | {seconds:.1f} |"


def readme(tables: dict[str, pd.DataFrame]) -> Iterator[str]:
    """Yield the lines of README.md."""
    yield from ("# Adaptive solvers: what the verifier is worth", "")
    yield f"Written by `measure.py` with {PATHS} paths a run, each solver judged alone on each problem."
    if "right" in tables:
        rows = tables["right"]
        runs = rows.groupby(["solver", "problem", "seed"])["verdict"]
        refuted = int(runs.agg(lambda each: Verdict.REFUTED in set(each)).sum())
        yield from ("", "## Right solvers", "", f"{refuted} of {len(runs)} runs are refuted.")
        yield from verdict_lines(rows, "all verified")
        seconds = rows.groupby(["solver", "problem", "seed"])["seconds"].first().groupby("seed").sum()
        yield from ("", f"One run of all of them takes {seconds.mean():.0f} seconds of one core in the mean.")
    if "wrong" in tables:
        yield from ("", "## Planted solvers, along paths")
        yield from verdict_lines(tables["wrong"], "refuted without the test of the limit")
        yield from ("", "The estimate of `planted-redraw-law` is a bias, the others are rates.")
    if "checks" in tables:
        yield from ("", "## Checks", "")
        yield from ("| solver | seeds | own steps fails | keeps its path fails |", "|---|---|---|---|")
        for name, cell in tables["checks"].fillna("").groupby("solver"):
            counts = [int(cell["failed"].str.contains(which).sum()) for which in ("own steps", "keeps its path")]
            yield f"| {name} | {len(cell)} | {counts[0]} | {counts[1]} |"
    if "law" in tables:
        yield from ("", "## The path at 2^-20 of the horizon, 20000 paths", "")
        for row in tables["law"].itertuples():
            yield f"* {row.what}: {row.value:.3f}, standard error {row.std_error:.3f}"
    if "work" in tables:
        yield from work_lines(tables["work"])


def work_lines(rows: pd.DataFrame) -> Iterator[str]:
    """Yield the table of errors against steps."""
    yield from ("", "## Errors against tries, rejected ones counted, on one path", "")
    yield "| problem | solver | tolerance | tries | rms | median | worst 1 % |"
    yield "|---|---|---|---|---|---|---|"
    for row in rows.itertuples():
        tolerance = "" if np.isnan(row.tolerance) else f"2^{np.log2(row.tolerance):.0f}"
        sizes = f"{row.rms:.2g} | {row.median:.2g} | {row.worst_hundredth:.2g}"
        yield f"| {row.problem} | {row.solver} | {tolerance} | {row.tries:.0f} | {sizes} |"


if __name__ == "__main__":
    known = load_and_warn((), lab=True)
    with one_thread():
        for wanted in sys.argv[1:] or TABLES:
            rows = list[dict[str, object]]()
            for row in TABLES[wanted](known):
                rows.append(row)
                pd.DataFrame(rows).to_csv(FOLDER / f"{wanted}.csv", index=False, float_format="%.6g")
    kept = {name: pd.read_csv(FOLDER / f"{name}.csv") for name in TABLES if (FOLDER / f"{name}.csv").exists()}
    (FOLDER / "README.md").write_text("\n".join(readme(kept)) + "\n")
