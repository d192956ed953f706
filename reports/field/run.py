"""Judges the solvers of other libraries, those that are installed: a folder for each run, and tables.md of all.

pip install '.[ase,diffrax,mici,qutip,sdeint,tinydiffeq,torchsde]' && python reports/field/run.py
"""

import os
import subprocess
import sys
from collections.abc import Iterator
from importlib.metadata import PackageNotFoundError, version
from pathlib import Path

import pandas as pd

FOLDER = Path(__file__).parent
ROOT = FOLDER.parents[1]
LIBRARIES = ("ase", "diffrax", "jax", "mici", "qutip", "sdeint", "tinydiffeq", "torch", "torchsde")
GENERAL = "spiral,noncommuting,levy-area,hyperbolic-pair,hyperbolic,gbm,linear-test"
ADDITIVE = "ou,double-well,angle-pendulum,harmonic-langevin,fibre-linear"
LINEAR = "spiral,noncommuting,gbm,linear-test,ou,harmonic-langevin,fibre-linear[N=2],circle,gbm-algebraic"
SOLVERS = "diffrax*,torchsde*,sdeint*,tinydiffeq*,ase*"
BUDGET, SMALL, LEAST = (
    f"--paths={n} --levels={levels}" for n, levels in ((1024, "16..128"), (256, "8..64"), (256, "2..16"))
)
# By folder: schemes, problems, measures and budget. QuTiP and mici make one path at a time. A step of QuTiP takes up
# to a millisecond with the seven noises of the default fibre, whose stiffness its short runs leave unresolved: it has
# two.
RUNS = {
    "sdes": (SOLVERS, f"{GENERAL},{ADDITIVE}", "strong,weak", BUDGET),
    "algebraic": (
        "tinydiffeq*",
        "gbm-algebraic,growing-volatility,nonlinear-constraint[tau=0]",
        "strong,weak",
        BUDGET,
    ),
    "ase": ("ase*", "angle-pendulum,harmonic-langevin", "invariant", BUDGET),
    "qutip-strong": ("qutip*", LINEAR, "strong", SMALL),
    "qutip-weak": ("qutip[method=pred_corr],qutip[method=platen]", LINEAR, "weak", SMALL),
    "mici": ("mici*", "damped-pendulum,pendulum-tangential,sphere-langevin", "weak,drift", LEAST),
}
KEEP = ("verified", "refuted", "inconclusive", "error")


def run(folder: Path, schemes: str, problems: str, measures: str, budget: str) -> None:
    """Run a part of the matrix into its folder; what was run before and is the same is used again."""
    command = [sys.executable, "-m", "sdaeverify", "matrix", "-s", schemes, "-p", problems, "-m", measures]
    given = {**os.environ, "OMP_NUM_THREADS": "1", "JAX_PLATFORMS": "cpu"}
    out = ("--out", str(folder.relative_to(ROOT)), "-q", *sys.argv[1:])
    done = subprocess.run([*command, *budget.split(), *out], cwd=ROOT, env=given, check=False)
    # 1 and 3: a claim is refuted, a cell is in error. Both stand in the tables.
    if done.returncode not in {0, 1, 3}:
        sys.exit(done.returncode)


def tables(rows: pd.DataFrame) -> Iterator[str]:
    """Yield the lines of tables.md: versions, a row for each solver, and what was refuted or is in error."""
    named = [f"{name} {found}" for name in LIBRARIES if (found := _version(name))]
    counts = rows["verdict"].value_counts()
    yield from ("# Solvers of other libraries, in tables", "", f"Written by `run.py` with {', '.join(named)}.", "")
    yield f"{rows['scheme'].nunique()} solvers on {rows['problem'].nunique()} problems, {len(rows)} quantities: "
    yield from (
        ", ".join(f"{counts.get(kind, 0)} {kind}" for kind in KEEP) + ". Orders are local ones, else of paths.",
        "",
    )
    for measure in ("strong", "weak", "invariant", "drift"):
        of_measure = rows[rows["measure"] == measure]
        yield from (
            "",
            f"## {measure.capitalize()}",
            "",
            "| solver | problem | claim | found | verdict |",
            "|---|---|---|---|---|",
        )
        for (scheme, problem), cell in of_measure.groupby(["scheme", "problem"], sort=True):
            yield f"| `{scheme}` | `{problem}` | {_claims(cell)} | {_found(cell)} | {_verdicts(cell)} |"
    yield from ("", "## Refuted or in error", "")
    for row in rows[rows["verdict"].isin(["refuted", "error"])].itertuples():
        yield f"* `{row.scheme}` on `{row.problem}`, {row.measure} of {row.quantity}, {row.claim}: {row.reason}"


def _claims(cell: pd.DataFrame) -> str:
    return ", ".join(dict.fromkeys(str(claim).removeprefix("order >= ") for claim in cell["claim"].dropna())) or "-"


def _found(cell: pd.DataFrame) -> str:
    orders = cell["local_order"].fillna(cell["path_order"]).dropna().unique()
    ends = sorted({f"{orders.min():.2f}", f"{orders.max():.2f}"}, key=float) if len(orders) else []
    return " to ".join(ends) or "-"


def _verdicts(cell: pd.DataFrame) -> str:
    counts = cell["verdict"].value_counts()
    return ", ".join(f"{kind} {counts[kind]}" for kind in counts.index)


def _version(name: str) -> str:
    try:
        return version(name)
    except PackageNotFoundError:
        return ""


if __name__ == "__main__":
    for name, part in RUNS.items():
        run(FOLDER / name, *part)
    found = pd.concat([pd.read_csv(FOLDER / name / "verdicts.csv") for name in RUNS], ignore_index=True)
    found = found[~found["problem"].str.startswith("every-equation")]
    (FOLDER / "tables.md").write_text("\n".join(tables(found.fillna({"quantity": "all"}))) + "\n")
