"""Judges sealed solvers of other libraries, those that are installed, and writes the figures into this folder.

`python reports/sealed/measure.py` makes all of them, `python reports/sealed/measure.py openmm` those that are named.
Each leaves tables, `NAME.csv` and `NAME-moments.csv`; `README.md` is written from all that are there.
"""

import sys
from collections.abc import Iterator
from importlib.metadata import PackageNotFoundError, version
from pathlib import Path

import numpy as np
import pandas as pd

from sdaeverify.commands import load_and_warn
from sdaeverify.numerics import GROUPS
from sdaeverify.studying import Registry, Source, select_problems
from sdaeverify_sealed.openmm import along, context_of
from sdaeverify_sealed.run import SealedRun, cells, select_solvers
from sdaeverify_sealed.sample import Budget, Plan, Runner

FOLDER = Path(__file__).parent
LANGEVIN, MIDDLE = "harmonic-langevin", "openmm-langevin-middle"
KINDS = {MIDDLE: "as OpenMM returns them", f"{MIDDLE}[on_step=true]": "at the time of the positions"}
MOMENTS = ("q^2", "p^2", "q p")
# Of the independent look at the spread between seeds.
SEEDS, PARTICLES = 4000, 1640
# By library: solvers, problems, budget, and the plugin file that registers them.
RUNS: dict[str, tuple[tuple[str, ...], tuple[str, ...], Budget, tuple[str, ...]]] = {
    "openmm": (tuple(KINDS), (LANGEVIN, "angle-pendulum"), Budget(paths=2**17), ()),
    "diffrax": (
        ("diffrax-heun", "diffrax-unsafe"),
        ("ou", "gbm[a=0.1,b=0.8]"),
        Budget(paths=2**15, looks=2),
        (str(FOLDER / "diffrax_solvers.py"),),
    ),
}


def verdicts(registry: Registry, library: str) -> Iterator[dict[str, object]]:
    """Yield a row for each claim and check of the solvers of a library."""
    names, labels, budget, _ = RUNS[library]
    solvers, specs = select_solvers(registry, names), [select_problems(registry, label)[0] for label in labels]
    # Each solver is judged alone: they have the same seeds, and share no family.
    for solver in solvers:
        run = SealedRun(cells([solver], specs, budget)[0], budget)
        for _ in run.run():
            pass
        for row in run.rows:
            found = row.finding
            told = {"verdict": found.verdict.value, "low": found.low, "high": found.high, "reason": str(found.reason)}
            about = {"measure": row.measure, "quantity": found.quantity, "claim": str(found.claim or "")}
            yield {"solver": solver.label, "problem": row.cell.label, **about, **told}


def moments(registry: Registry) -> Iterator[dict[str, object]]:
    """Yield stationary moments of OpenMM's integrator at three step sizes, beside those of theory."""
    problem = select_problems(registry, LANGEVIN)[0].build()
    kT = problem.strength**2 / (2.0 * problem.friction)
    omega2 = -float(problem.force(np.ones((1, 1)))[0, 0])
    plan = Plan("invariant", 32.0, np.array([0.5, 0.25, 0.125]), MOMENTS)
    for solver in select_solvers(registry, tuple(KINDS)):
        on_step = bool(getattr(solver, "on_step"))  # noqa: B009 - a field of one solver
        look, _ = Runner(solver, problem, Source(7, LANGEVIN, 0, 1)).look(plan, 0, 4000)
        for h, means in zip(plan.h, look.means, strict=True):
            known = (kT / omega2, kT * (1.0 - on_step * 0.25 * h * h * omega2), (not on_step) * 0.5 * h * kT)
            spread = means.std(axis=0, ddof=1) / GROUPS**0.5
            for name, mean, se, theory in zip(MOMENTS, means.mean(axis=0), spread, known, strict=True):
                yield {
                    "solver": solver.label,
                    "h": h,
                    "moment": name,
                    "mean": mean,
                    "std_error": se,
                    "theory": theory,
                }


def spread(registry: Registry) -> Iterator[dict[str, object]]:
    """Yield how velocities after one step spread between seeds, on each axis: an independent look at a check.

    The ratio of the variance of means between seeds to the variance of the particles of a run over their number is 1
    for independent numbers, with a standard error of (2/runs)^(1/2).
    """
    problem, rng = select_problems(registry, LANGEVIN)[0].build(), np.random.default_rng(123)
    context = context_of(problem, 1.0, PARTICLES, 1)
    start, still = along(np.ones(PARTICLES)), along(np.zeros(PARTICLES))
    means, within = np.empty((SEEDS, 3)), np.empty((SEEDS, 3))
    for run in range(SEEDS):
        context.getIntegrator().setRandomNumberSeed(int(rng.integers(1, 2**31 - 1)))
        context.reinitialize()
        context.setPositions(start)
        context.setVelocities(still)
        context.getIntegrator().step(1)
        v = context.getState(velocities=True).getVelocities(True)._value
        means[run], within[run] = v.mean(axis=0), v.var(axis=0, ddof=1) / PARTICLES
    for axis, ratio in zip("xyz", means.var(axis=0, ddof=1) / within.mean(axis=0), strict=True):
        yield {
            "axis": axis,
            "seeds": SEEDS,
            "particles": PARTICLES,
            "ratio": ratio,
            "std_error": (2.0 / SEEDS) ** 0.5,
        }


def readme(tables: dict[str, pd.DataFrame]) -> Iterator[str]:
    """Yield the lines of README.md."""
    named = [f"{name} {_version(name)}" for name in ("openmm", "diffrax", "jax") if _version(name)]
    yield from ("# Sealed solvers of other libraries", "", f"Written by `measure.py` with {', '.join(named)}.")
    for library in (name for name in RUNS if name in tables):
        yield from verdict_lines(library, tables[library])
    if "openmm-moments" in tables:
        yield from moment_lines(tables["openmm-moments"])
    if "openmm-spread" in tables:
        yield from spread_lines(tables["openmm-spread"])
    yield from ("", "## Refuted, and facts", "")
    for table in (tables[library] for library in RUNS if library in tables):
        for row in table.itertuples():
            if row.verdict in {"refuted", "not_applicable"}:
                yield f"* `{row.solver}` on `{row.problem}`, {row.measure}: {row.verdict}: {row.reason}"


def verdict_lines(library: str, table: pd.DataFrame) -> Iterator[str]:
    """Yield the table of the verdicts on the solvers of a library."""
    yield from ("", f"## {library}", "", "| solver | problem | about | claim | found | verdict |")
    yield "|---|---|---|---|---|---|"
    for row in table.fillna({"quantity": "", "claim": ""}).itertuples():
        about = f"{row.measure} of {row.quantity}" if row.quantity else row.measure
        found = f"{row.low:.2g} to {row.high:.2g}" if np.isfinite(row.low) else ""
        yield f"| {row.solver} | {row.problem} | {about} | {row.claim} | {found} | {row.verdict} |"


def moment_lines(table: pd.DataFrame) -> Iterator[str]:
    """Yield the finding on velocities, and the table of moments."""
    text = """
## Finding: the velocities of LangevinMiddleIntegrator

OpenMM documents that LFMiddle "returns half step (leapfrog) velocities", which "provide a much more accurate sampling
of the thermal ensemble", and BAOAB's on-step velocities for the same positions. In a harmonic well the stationary law
is normal, and the invariance of its covariance under one step gives, with v as returned and p = v + (h/2) F(q),

    E q^2 = kT/omega^2,   E v^2 = kT,   E q v = h kT/2,   E p^2 = kT (1 - h^2 omega^2/4),   E q p = 0.

So positions and temperature of the returned velocities are exact, as documented, while the two are not those of one
time: their correlation is off by h kT/2. Velocities at the time of the positions have no such correlation, and a
temperature that is too low by the part h^2 omega^2/4; a claim that it is right is refuted by that size.
`openmm_check.py` has the same figures from OpenMM and NumPy alone (`openmm_check.txt`). Nothing is wrong in OpenMM.

| velocities | h | moment | found | theory |
|---|---|---|---|---|"""
    yield from text.splitlines()
    for row in table.itertuples():
        found = f"{row.mean:.4f} +- {row.std_error:.4f}"
        yield f"| {KINDS[row.solver]} | {row.h:g} | {row.moment} | {found} | {row.theory:.4f} |"


def spread_lines(table: pd.DataFrame) -> Iterator[str]:
    """Yield what further seeds say of the spread between seeds."""
    text = """
## No finding: the standard errors of OpenMM

Where the check `standard errors` is refuted above for OpenMM it is a false alarm, of which the level allows one in a
hundred runs. Both rows are of the same seeds and positions. Further seeds, with one step of each particle:

| axis | seeds | particles | variance between seeds, over that of independent particles |
|---|---|---|---|"""
    yield from text.splitlines()
    for row in table.itertuples():
        yield f"| {row.axis} | {row.seeds} | {row.particles} | {row.ratio:.3f} +- {row.std_error:.3f} |"


def _version(name: str) -> str:
    try:
        return version(name)
    except PackageNotFoundError:
        return ""


def main() -> None:
    """Measure, and write the tables."""
    for library in sys.argv[1:] or RUNS:
        if _version(library):
            registry = load_and_warn(RUNS[library][3], lab=True)
            pd.DataFrame(verdicts(registry, library)).to_csv(FOLDER / f"{library}.csv", index=False)
            if library == "openmm":
                pd.DataFrame(moments(registry)).to_csv(FOLDER / "openmm-moments.csv", index=False)
                pd.DataFrame(spread(registry)).to_csv(FOLDER / "openmm-spread.csv", index=False)
    tables = {path.stem: pd.read_csv(path) for path in sorted(FOLDER.glob("*.csv"))}
    (FOLDER / "README.md").write_text("\n".join(readme(tables)) + "\n", encoding="utf-8")


if __name__ == "__main__":
    main()
