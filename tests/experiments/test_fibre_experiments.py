"""The experiments on fibres: their norms, their shared noise, and small runs of them."""

import csv
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from experiments.running import evidence_of
from facade import EXPERIMENTS, Budget, SharedNoise, clamped_chain, fibre_clamped
from facade import lindner_2018_figure_4_2 as convergence
from facade import lindner_2018_figure_4_3 as skipping
from facade import lindner_2018_figure_5_1 as refinement
from sdaeverify.studying import Brownian, Source
from sdaeverify_lab.papers.experiments._estimates import mean, mean_count, order
from sdaeverify_lab.papers.experiments._fibres import A, B, differences, edges, spacing

pytestmark = pytest.mark.long


@pytest.mark.parametrize(("p", "reference"), [(1.0, 0.0), (1.0, 1 / 256), (0.5, 1 / 256), (2.0, 1 / 64)])
def test_order_against_a_reference(p, reference):
    """The order of C (h^p - h_ref^p) is p, whatever the reference's own error takes from the errors."""
    h, size = 2.0 ** -np.arange(2, 6), np.random.default_rng(1).exponential(size=50)

    fitted = order(h, np.outer(h**p - reference**p, size), reference)

    # Twenty rounds of a fixed point: what is left is far below the error of any sample.
    assert fitted.value == pytest.approx(p, abs=1e-4)
    assert fitted.std_error < 1e-10


def test_order_has_the_error_of_its_sample():
    """Of 300 repetitions the order is off by what its standard error says."""
    rng, h, off = np.random.default_rng(2), 2.0 ** -np.arange(2, 6), []
    for _ in range(300):
        fitted = order(h, np.outer(h, np.ones(100)) * rng.exponential(size=(4, 100)))
        off.append((fitted.value - 1.0) / fitted.std_error)

    # A normal variable of 300 draws has a deviation within 0.17 of 1 at four standard errors; 0.1 is for its bias.
    assert 0.73 < np.std(off) < 1.27
    assert abs(np.mean(off)) < 4.0 / 300**0.5 + 0.1


def test_interval():
    """Nine of ten intervals hold the mean."""
    values = np.random.default_rng(3).standard_normal((2000, 100))
    found = mean(values)

    held = ((found.low < 0.0) & (found.high > 0.0)).mean()
    # Four standard errors of a share of 2000.
    assert abs(held - 0.9) < 4.0 * (0.09 / 2000) ** 0.5 + 0.005


def test_edges_are_those_of_the_chain():
    """Edges and differences of velocities are those by which the problem is constrained."""
    chain = clamped_chain(5, 2)
    r, v = np.random.default_rng(4).standard_normal((2, 10, 3))

    assert spacing(5) == chain.ds
    assert edges(r) == pytest.approx(chain.edges(r), abs=1e-15)
    assert differences(v) == pytest.approx(chain.differences(v), abs=1e-15)


def test_coarse_noise_is_that_of_the_fine_cells():
    """Cells are joined with their variance, in any order, and before or after steps are (Chen's relation)."""
    source = Source(7, "cells", 0, 400)
    coarse, fine = next(iter(Brownian(source, 2 * 31, 1.0, 3).steps()))[0::3]
    sums = refinement.CellSums(8, 32)

    direct = sums(fine.dW)
    through = refinement.CellSums(8, 16)(refinement.CellSums(16, 32)(fine.dW))
    assert direct == pytest.approx(through, abs=1e-14)
    assert direct.sum(axis=0, keepdims=True) == pytest.approx(sums(coarse.dW), abs=1e-13)
    # 8 steps of 1/8, 14 components, 400 paths: variances 1/8 with a relative error of (2/44800)^(1/2).
    assert direct.var() * 8.0 == pytest.approx(1.0, abs=4.0 * (2.0 / direct.size) ** 0.5)
    # Noise that is added without the root of the number of cells is twice as large.
    assert abs((2.0 * direct).var() * 8.0 - 1.0) > 4.0 * (2.0 / direct.size) ** 0.5


def test_cells_keep_their_place():
    """A coarse cell is that of its fine cells: means of a linear profile are its values at the coarse points."""
    fine, coarse = (clamped_chain(cells - 1, 2) for cells in (32, 8))
    profile = np.repeat(fine.arc_lengths, 2)[:, None]

    assert refinement.on_cells(profile, 8)[:, 0, 0] == pytest.approx(coarse.arc_lengths, abs=1e-15)


def test_fibres_of_different_grids_on_one_noise(registry):
    """Two fibres on one white noise move together, and their tips have the law of the linear equation."""
    law = Law()
    evidence = evidence_of(registry, law.name, law, paths=40)

    tips = [refinement._tip_positions(evidence, cells, "r") for cells in (10, 40)]
    for cells, x in zip((10, 40), tips, strict=True):
        exact, _ = refinement._scale(cells, "r")
        # A deviation of 40 normal draws has a relative error of 1/sqrt(78); the linearisation one of 1.5 percent.
        assert x.std(ddof=1) == pytest.approx(exact, rel=4.0 / 78**0.5 + 0.015)
    assert np.corrcoef(tips)[0, 1] > 0.9


class Law(refinement.SpaceTime):
    """The runs of the law alone, in a tenth of the steps."""

    def work(self, budget):
        return {key: replace(run, steps=64) for key, run in super().work(budget).items() if key[0] == "law"}


class Short(convergence.Convergence):
    """Schemes of the soft fibre with few steps."""

    def cases(self, budget):
        steps = dict.fromkeys(convergence.NAMES, (32, 64, 256))
        return (convergence.Case("4.0", "0.015625", steps),)


@pytest.mark.slow
def test_schemes_converge_on_the_fibre(registry):
    """(A), (B) and (B') have order 1 at alpha = 4 and little noise, and an error is told from one of order 1/2."""
    short = Short()
    evidence = evidence_of(registry, short.name, short, paths=4)
    (case,) = short.cases(Budget.SMOKE)

    for scheme in convergence.NAMES:
        found = convergence.errors(evidence, case, "0.0001", scheme, "(r, v)")
        h = np.array([case.h(steps) for steps in case.steps[scheme][:-1]])
        fitted = order(h, found, case.h(256))
        # Terms of higher order change the slope by a part of h over the fastest time, here below a tenth.
        assert abs(fitted.value - 1.0) < 0.1 + 4.0 * fitted.std_error
        assert fitted.value - 0.5 > 4.0 * fitted.std_error
    exhibit = short.exhibit(evidence)
    assert {entry.at["scheme"] for entry in exhibit.entries if "scheme" in entry.at} == {"(A)", "(B)", "(B')"}


class Few(skipping.Skipping):
    """A few steps of each."""

    def setting(self, budget):
        return skipping.Setting("0.00390625", 2**9, (0, 10, 100))


def test_defects_grow_with_the_skipped_steps(registry):
    """With every projection the constraints hold to rounding; between projections they are left, more with more."""
    few = Few()
    evidence = evidence_of(registry, few.name, few, paths=3)
    at = few.setting(Budget.SMOKE)

    for note in ("length", "velocity"):
        none, some, many = (float(skipping.defect(evidence, at, note, skip).value) for skip in at.skips)
        # Rounding of squares of size 1 on 7 edges, at positions known to EPS |r|/ds.
        assert none < 1e-13
        assert 1e-9 < some < many
    for skip in at.skips:
        assert 1.0 <= mean_count(evidence, (skip, "0.0")).value <= 3.0
    assert mean_count(evidence, (100, "1e-08")).value <= mean_count(evidence, (100, "1e-11")).value
    assert 1.0 <= skipping.count_if_early(evidence, 10).value <= skipping.count_if_early(evidence, 100).value <= 2.0


def test_defects_are_tested_on_the_position_that_is_to_be_projected():
    """A straight fibre that turns about r_0 with angular velocity 1 has | |d_s r|^2 - 1 | = h^2 after a free step."""
    problem = fibre_clamped(N=3)
    r, _, _ = problem.initial(1)
    turning = np.zeros_like(r)
    turning[::2, 0] = -r[1::2, 0] - 0.5 * spacing(3)
    bound = np.sqrt(skipping.BEFORE / np.sqrt(3 * spacing(3)))

    for h, above in ((0.999 * bound, 0.0), (1.001 * bound, 1.0)):
        assert skipping.AboveBefore(h)(problem, 0.0, {"r": r, "v": turning}) == [above]


def test_runs_share_what_the_experiment_says(registry):
    """Grids of one turbulence have one noise; stiffnesses and turbulences have their own."""
    work = registry.things(EXPERIMENTS)["lindner-2018-figure-5-1"].work(Budget.SMOKE)
    noises = {key: run.noise for key, run in work.items()}

    assert len({noise for key, noise in noises.items() if key[0] == "0.1"}) == 1
    assert noises["0.1", 8] != noises["0.0001", 8]
    assert all(isinstance(noise, SharedNoise) for noise in noises.values())
    assert {A, B} <= {run.scheme for run in convergence.sdaeverify_experiments()[0].work(Budget.FULL).values()}


def test_a_step_of_b_costs_a_fraction_with_gram_matrices_alone():
    """As the note of figure 4.4 says: in the kept table dense Newton systems cost more than (A) from 20 points on."""
    file = Path(__file__).parents[2] / "reports" / "papers" / "lindner-2018-figure-4-4-right" / "table.csv"
    with file.open(newline="", encoding="utf-8") as table:
        rows = [row for row in csv.DictReader(table) if row["group"].startswith("seconds")]
    ratios = {(row["scheme"], int(row["N"])): float(row["value"]) for row in rows}

    assert max(ratio for (name, _), ratio in ratios.items() if name == "(B), Gram") < 0.1
    assert min(ratio for (name, n), ratio in ratios.items() if name == "(B), Newton" and n >= 20) > 1.0
    assert ratios["(B), Newton", 5] < 1.0
