"""The experiments that need no fibre: they come out as theory says, and a wrong scheme or formula would show."""

import numpy as np
import pytest
from rich.console import Console

from experiments.running import evidence_of
from facade import (
    EXPERIMENTS,
    Budget,
    Curve,
    Exhibit,
    HalfExplicitEuler,
    Panel,
    Range,
    entry_tables,
    experiment_plan,
    pendulum,
)
from facade import laurent_2022_figure_1 as torus
from facade import lindner_2017_multipliers as multipliers
from facade import lindner_2017_roots as roots
from sdaeverify_lab.papers.picture import draw

pytestmark = pytest.mark.long

PAPERS = ("laurent-2022", "lindner-2017", "lindner-2018", "qu-2010")
QUICK = (
    "errata",
    "lindner-2018-figure-2-1",
    "lindner-2017-constants",
    "lindner-2017-estimate-3-17",
    "lindner-2017-figure-5-1",
    "lindner-2017-remark-3-5",
    "lindner-2018-lemma-9",
    "laurent-2022-theorem-2-12",
)


def ran(registry, name, paths=None, experiment=None):
    """Run an experiment, changed or not, in this process, and return its exhibit."""
    thing = experiment or registry.things(EXPERIMENTS)[name]
    return thing.exhibit(evidence_of(registry, name, thing, paths))


def test_every_paper_is_there(registry):
    """Each of the four papers has experiments, and their labels name what is registered, at both budgets."""
    for paper in PAPERS:
        assert any(name.startswith(paper) for name in registry.things(EXPERIMENTS))
    for name in registry.things(EXPERIMENTS):
        for budget in Budget:
            assert experiment_plan(registry, name, budget=budget).keys


@pytest.mark.parametrize("name", QUICK)
def test_tables_fit_a_terminal(registry, name):
    """Headings and rows are 80 columns wide at most."""
    console = Console(width=200, color_system=None)
    with console.capture() as capture:
        for part in entry_tables(ran(registry, name).entries):
            console.print(part)
    assert max(map(len, map(str.rstrip, capture.get().splitlines()))) <= 80


def test_kappa(registry):
    """Roots are those of the circle's equation; with truncation there is always one, below C_kappa."""
    exhibit = ran(registry, "lindner-2017-figure-5-1")

    found = {(entry.group.endswith("truncated"), entry.at["omega h"]): entry for entry in exhibit.entries}
    assert found[False, 1.3].at["root"] == "no"
    assert np.isnan(found[False, 1.3].value)
    for (truncated, turn), entry in found.items():
        if truncated or turn < 1.0:
            # Newton's method to rounding on an equation whose derivative is at least 0.7.
            assert entry.value == pytest.approx(entry.exact, abs=1e-14)
    assert max(entry.value for (truncated, _), entry in found.items() if truncated) < 1.0 / 8.0


def test_multiplier_exponents():
    """Remainders are those of the closed form, which a multiplier along the new normal is told from."""
    found = multipliers.remainders((pendulum(), pendulum(c_g=0.0)), (HalfExplicitEuler(truncation="none"),))
    wrong = multipliers.remainders((pendulum(),), (AlongNewNormals(truncation="none"),))

    for name in multipliers.ORDERS:
        assert found[f"{name} here"] == pytest.approx(found[f"{name} exact"], abs=1e-14)
    assert np.abs(wrong["lambda^re here"] - wrong["lambda^re exact"]).max() > 1e-6


class AlongNewNormals(HalfExplicitEuler):
    """A velocity that is corrected along the new normal, whose multiplier is another one."""

    def step(self, problem, state, t, h, noise):
        step = super().step(problem, state, t, h, noise)
        return step._replace(outputs={**step.outputs, "lambda": step.outputs["lambda"] * np.cos(np.arcsin(1.1 * h))})


def test_share_without_root(registry):
    """Shares of paths are those of the chain, to four standard errors; those of half the step size are told apart."""
    exhibit = ran(registry, "lindner-2017-section-5-1-roots", paths=500)
    found = {(e.group.split()[-1], e.at["omega_0"], e.at["h"]): e for e in exhibit.entries}

    for (truncation, _, _), entry in found.items():
        assert entry.value_and_expected == "agrees"
        if truncation == "theory":
            assert entry.value == 0.0
    at = found["none", 4.0, 1 / 16]
    assert abs(at.value - roots.exact_share(4.0, 1 / 32, 32)) > 4.0 * at.std_error


def test_exact_share():
    """The operator's share is that of many chains drawn directly, and 1 and 0 where the first step decides."""
    rng, omega, h = np.random.default_rng(5), np.full(200000, 2.0), 0.25
    lost = np.zeros(len(omega), dtype=bool)
    for _ in range(4):
        lost |= np.abs(omega) * h >= 1.0
        with np.errstate(invalid="ignore"):
            omega = (omega + np.sqrt(h) * rng.standard_normal(len(omega))) / np.sqrt(1.0 - (omega * h) ** 2)
        omega = np.where(lost, 9.0, omega)

    share = roots.exact_share(2.0, 0.25, 4)
    assert abs(lost.mean() - share) < 4.0 * (share * (1.0 - share) / len(omega)) ** 0.5
    assert roots.exact_share(4.0, 0.25, 4) == 1.0
    assert roots.exact_share(1.0, 0.25, 1) == 0.0


def test_constants(registry):
    """Norms around circle and spheres are those of the closed form, and |G| of a straight fibre its eigenvalue."""
    exhibit = ran(registry, "lindner-2017-constants")

    checked = [entry for entry in exhibit.entries if entry.exact_source == "closed form"]
    assert len(checked) == 6
    for entry in checked:
        # Random directions reach the axes of a mass matrix exactly: they are among them.
        assert entry.value == pytest.approx(entry.exact, rel=1e-12)


def test_errata(registry):
    """Right formulas give the exact numbers and printed ones do not."""
    found = {entry.at["of"]: entry for entry in ran(registry, "errata").entries}

    right = found["order of Dg(r+) v+ of an unprojected step, minus"]
    printed = found["the same with the printed plus"]
    # Powers of h with one term: slopes are exact to rounding; the printed sign adds a term of order 2.
    assert right.value == pytest.approx(2.0, abs=1e-6)
    assert printed.value == pytest.approx(1.0, abs=0.02)
    assert found["largest difference of the sums"].value < 1e-12 * found["largest sum, q = 1, 2, 3, 6"].value
    assert found["c_g in the step, c_g = 2"].value == pytest.approx(2.0, rel=1e-14)
    assert found["median of the averages"].value < 0.1 * found["median of the averages"].exact
    (branch,) = (entry for of, entry in found.items() if of.startswith("largest B^2"))
    assert branch.value < 1.0


def test_slips_in_proofs(registry):
    """The right line holds to rounding, and the printed one is off by far more."""
    found = {(entry.group.split()[0], entry.at["of"]): entry.value for entry in ran(registry, "errata").entries}

    mass, bound, theta = (
        [found[paper, f"{of}, {name}"] for name in ("right", "printed")]
        for paper, of in (
            ("LS", "|g| at the step's own kappa, M = diag(1, 2, 4)"),
            ("LS", "|eta - 1| over its bound, at most 1; |v| = 100, h = 0.01"),
            ("Qu", "difference of the two sides of (4.2)"),
        )
    )
    for right, printed in (mass, theta):
        # A few roundings of numbers of size 1.
        assert right < 1e-14
        assert printed > 1e-3
    assert bound[0] < 1.0 < bound[1]
    assert found["Qu", "rate of E x^2 at the a between, which is said to be stable"] > 0.0


def test_weaker_truncation(registry):
    """Both truncations keep the powers of h, and the weaker one alone lets a remainder grow with the velocity."""
    found = {tuple(entry.at.values())[:2]: [] for entry in ran(registry, "lindner-2017-remark-3-5").entries}
    for entry in ran(registry, "lindner-2017-remark-3-5").entries:
        found[tuple(entry.at.values())[:2]].append(entry.value)

    for (truncation, part), (in_h, in_v) in found.items():
        assert in_h == pytest.approx(2.0 if part == "lambda^re" else 1.0, abs=0.02)
        if (truncation, part) == ("weak, |v|", "lambda^re"):
            # |v| (tan phi - sin phi) at the constant angle phi that the truncation leaves.
            assert in_v == pytest.approx(1.0, abs=1e-3)
        else:
            assert in_v <= 0.0


def test_gram_determinant(registry):
    """The bound of Lemma 9 holds; that of the straight fibre itself, ds^(-2N), does not hold near the manifold."""
    least = [entry.value for entry in ran(registry, "lindner-2018-lemma-9").entries]
    assert min(least) > 0.0
    assert max(least) < np.log(4.0)
    # Shortening the first segment of N = 2 to 3 ds/4 is among the displacements.
    assert least[0] <= np.log(4.0) + np.log(9.0 / 16.0) / 2.0 + 1e-12


def test_contraction(registry):
    """The shipped step is a fixed point of the map of the theorem, whose factor falls like h^(1/2)."""
    exhibit = ran(registry, "laurent-2022-theorem-2-12")
    values = {next(iter(entry.at.values())): entry.value for entry in exhibit.entries}

    assert float(exhibit.remarks[0].split()[-1].rstrip(".")) < 1e-14
    assert all(values[h] < 1.0 for h in values if not isinstance(h, str))
    # The next power of h is still seen in the slope.
    assert values["slope over h = 2^-6 to 2^-16"] == pytest.approx(0.5, abs=0.05)
    assert values["largest over smallest eps, at any h"] < 2.0


def test_moments_for_all_stiffnesses(registry):
    """Moments fall with eps to those on the circle; explicit Euler's are lost where h is far above eps."""
    entries = ran(registry, "laurent-2022-moments", paths=50).entries
    found = {(entry.group.split(", ")[1], *entry.at.values()): entry for entry in entries}

    for h in (0.125, 0.03125):
        first = found["uniformly accurate (2.2)", 1e-8, h]
        assert abs(first.value - 1.0) < 4.0 * first.std_error + 1e-3
        assert np.isnan(found["Euler (1.5)", 1e-8, h].value)


def test_fourth_moments(registry):
    """They grow with the time, and stay below the bound with C = 1."""
    entries = ran(registry, "lindner-2018-theorem-7", paths=20).entries
    found = {(entry.group.split()[0], entry.at["T"]): entry.value for entry in entries if "T" in entry.at}

    moments = [found["E", T] for T in (1, 2, 4, 8)]
    assert moments == sorted(moments)
    assert all(np.log(found["E", T]) < found["log", T] for T in (1, 2, 4, 8))


@pytest.mark.slow
def test_penalised_dynamics(registry):
    """Both dynamics are off by eps in the mean square, and E zeta^2 is the leading term of each, not the other's."""
    found = {
        (entry.group[:6], *entry.at.values()): entry for entry in ran(registry, "laurent-2022-theorem-2-3").entries
    }

    for form, other in (("(1.3)", "(1.4)"), ("(1.4)", "(1.3)")):
        entry = found["E zeta", "E zeta(X^eps(T))^2", form]
        # The leading term is off by O(eps), eps = 2^-8, and Euler's steps by 1 %.
        assert abs(entry.value - entry.exact) < 4.0 * entry.std_error + 0.02 * entry.exact
        assert abs(entry.value - found["E zeta", "E zeta(X^eps(T))^2", other].exact) > 8.0 * entry.std_error
        assert found["expone", "sup_t E |X^eps - X^0|^2", form].value == pytest.approx(1.0, abs=0.1)


def test_sup_norms(registry):
    """On the grid v has order 1 with additive noise, in continuous time about the slope of (h log 1/h)^{1/2}."""
    found = {
        (entry.group.split(", ")[1], entry.at["of"], entry.at["sup over"]): entry
        for entry in ran(registry, "lindner-2017-theorem-4-1", paths=40).entries
        if "sup over" in entry.at
    }

    for part in ("r", "v", "mu"):
        grid = found["B = Id", part, "grid"]
        assert abs(grid.value - 1.0) < 0.1 + 4.0 * grid.std_error
    rough = found["B = Id", "v", "all t, linear"]
    # The slope of (h log 1/h)^{1/2} over these h is 0.38; noise of order 1 beside it steepens it on coarse grids.
    assert abs(rough.value - 0.38) < 0.1 + 4.0 * rough.std_error
    half = found["B = v", "v", "grid"]
    assert abs(half.value - 0.5) < 0.1 + 4.0 * half.std_error


class OneTorus(torus.StationaryErrors):
    """One of the runs."""

    def work(self, budget):
        key = torus.UNIFORM, "0.001", 9
        return {key: super().work(budget)[key]}

    def exhibit(self, evidence):
        return Exhibit(tuple(torus._entries(evidence, torus.UNIFORM, "0.001", 9)))


def test_stationary_errors(registry):
    """Time averages on the torus see the scheme's bias at eps = 0.001 as measured before, 0.0452 at h = 10/2^9."""
    (entry,) = ran(registry, OneTorus.name, paths=60, experiment=OneTorus()).entries

    assert abs(entry.value - 0.0452) < 4.0 * np.hypot(entry.std_error, 0.0005)
    # Half the step size has 0.0188.
    assert abs(entry.value - 0.0188) > 4.0 * entry.std_error


def test_a_picture_of_everything(tmp_path):
    """Every kind of curve is drawn, the same way each time; without matplotlib it is said how to get it."""
    pytest.importorskip("matplotlib")
    x = np.array([1.0, 10.0, 100.0])
    kinds = ("points", "marks", "line", "band", "guide", "printed")
    curves = tuple(Curve(kind, x, x**2, 0.9 * x**2, 1.1 * x**2, kind) for kind in kinds)
    panels = [Panel("log", "x", "y", curves, "xy", (Range(1.0, 5.0, "here"),)), Panel("plain", "x", "y", curves[:2])]

    for name in ("a.svg", "b.svg", "c.png"):
        draw(panels, "title", tmp_path / name)

    assert (tmp_path / "a.svg").read_bytes() == (tmp_path / "b.svg").read_bytes()
    assert (tmp_path / "c.png").stat().st_size > 10000
