"""Order conditions of other forms: Langevin dynamics, equations of index 1, and a form of somebody else's."""

from dataclasses import dataclass, replace
from typing import ClassVar

import numpy as np
import pytest

from facade import ExactMoments, Examined, grow_nodes, integral, probe_of, told_apart, tree
from sdaeverify import SDE, Claim, DelayState, IndexOneSDAE, Langevin, Problem, Scheme, Step, UsageError, verify
from sdaeverify.trees import Node, Posed, Relatives, TreeClass
from sdaeverify_orders import orders
from sdaeverify_schemes.baoab import BAOAB
from sdaeverify_schemes.delays.stochastic_theta import StochasticTheta
from sdaeverify_schemes.quicsort import QUICSORT

pytestmark = pytest.mark.long

LANGEVIN, GRADIENT = Langevin.tree_classes()
INDEX_ONE, ADDITIVE = IndexOneSDAE.tree_classes()
# Orders (strong, weak) that are found.
FOUND = [
    ("baoab", "langevin", 1.0, 2.0),
    ("baoab", "langevin-gradient", 1.0, 2.0),
    ("quicsort", "langevin", 3.0, 3.0),
    ("quicsort", "langevin-gradient", 3.0, 3.0),
    ("stochastic-theta", "index-1", 0.5, 1.0),
    ("stochastic-theta", "index-1-additive", 1.0, 2.0),
    ("stochastic-theta[theta=1]", "index-1-additive", 1.0, 1.0),
    ("lagged-algebraic-theta", "index-1", 0.5, 1.0),
    ("lagged-algebraic-theta", "index-1-additive", 1.0, 1.0),
    ("drift-implicit-milstein", "index-1", 1.0, 1.0),
    ("drift-implicit-milstein", "index-1-additive", 1.0, 1.0),
]


@pytest.mark.sweep(others="slow")
@pytest.mark.parametrize(("scheme", "kind", "strong", "weak"), FOUND)
def test_shipped_schemes_have_the_orders_that_they_claim(scheme, kind, strong, weak):
    """The orders found are those that are known, and each claim is verified."""
    table = orders(scheme, kind, 1 if kind == "index-1" else 2).table

    assert list(table.order) == [strong, weak]
    assert set(table.verdict[table.claim.notna()]) == {"verified"}


@dataclass(frozen=True)
class RationalFriction(Scheme):
    """Gronbech-Jensen and Farago's scheme: friction by (1 - gamma h/2)/(1 + gamma h/2), which has a pole."""

    stronger: float = 1.0

    name: ClassVar[str] = "rational-friction"
    form: ClassVar[type] = Langevin
    claims: ClassVar = (
        Claim(measure="strong", value=1.0, source="Gronbech-Jensen & Farago 2013"),
        Claim(measure="weak", value=2.0, source="Gronbech-Jensen & Farago 2013"),
    )

    def step(self, problem, state, t, h, noise):
        """Make one step."""
        n, half, kick = problem.noise_dim, 0.5 * h * self.stronger * problem.friction, problem.strength * noise.dW
        q, p = state[:n], state[n:]
        b, F = 1.0 / (1.0 + half), problem.force(q)
        a = b * (1.0 - half)
        moved = q + b * h * (p + 0.5 * h * F + 0.5 * kick)
        return Step(np.concatenate([moved, a * p + 0.5 * h * (a * F + problem.force(moved)) + b * kick]))


@pytest.mark.parametrize(("stronger", "verdict"), [(1.0, "verified"), (1.0001, "refuted")])
def test_friction_that_is_a_fraction_is_told_from_what_is_wrong(stronger, verdict):
    """What the interpolation of a function with a pole leaves is no defect of a scheme; a wrong friction is one."""
    assert set(orders(RationalFriction(stronger), "langevin", 2).table.verdict) == {verdict}


class ScaledK(QUICSORT):
    """QUICSORT that is given 0.95 K."""

    name: ClassVar[str] = "wrong-scaled-k"

    def step(self, problem, state, t, h, noise):
        """Make one step."""
        return super().step(problem, state, t, h, noise._replace(K=0.95 * noise.K))


class FirstForAll(BAOAB):
    """BAOAB that drives all momenta by the first Brownian motion."""

    name: ClassVar[str] = "wrong-first-for-all"

    def step(self, problem, state, t, h, noise):
        """Make one step."""
        return super().step(problem, state, t, h, noise._replace(dW=np.broadcast_to(noise.dW[:1], noise.dW.shape)))


class NearForce(BAOAB):
    """BAOAB with the force at 0.98 q, which is right at the origin."""

    name: ClassVar[str] = "wrong-near-force"

    def step(self, problem, state, t, h, noise):
        """Make one step."""
        return super().step(replace(problem, force=lambda q: problem.force(0.98 * q)), state, t, h, noise)


class HalfFriction(BAOAB):
    """BAOAB with another friction."""

    name: ClassVar[str] = "wrong-half-friction"

    def step(self, problem, state, t, h, noise):
        """Make one step."""
        return super().step(replace(problem, friction=0.98 * problem.friction), state, t, h, noise)


class Traced(BAOAB):
    """BAOAB with h^2 (tr DF) p: equivariant under invertible maps alone."""

    name: ClassVar[str] = "wrong-traced"

    def step(self, problem, state, t, h, noise):
        """Make one step."""
        n, e = problem.noise_dim, 1e-6
        q, p = state[:n], state[n:]
        units = e * np.eye(n)[..., None]
        trace = sum((problem.force(q + u) - problem.force(q - u))[i] / (2.0 * e) for i, u in enumerate(units))
        return Step(super().step(problem, state, t, h, noise).state + h**2 * np.concatenate([0.0 * q, trace * p]))


class RootFriction(BAOAB):
    """BAOAB with noise that is larger by a term of sqrt(gamma h), of which no derivative by gamma is finite at 0."""

    name: ClassVar[str] = "wrong-root-friction"

    def step(self, problem, state, t, h, noise):
        """Make one step."""
        larger = 1.0 + 0.01 * np.sqrt(problem.friction * h)
        return super().step(problem, state, t, h, noise._replace(dW=larger * noise.dW))


class StrongerY(StochasticTheta):
    """The theta method whose y moves 2 per cent too far."""

    name: ClassVar[str] = "wrong-stronger-y"

    def step(self, problem, state, t, h, noise):
        """Make one step."""
        after = super().step(problem, state, t, h, noise)
        if not isinstance(state, DelayState):
            return after
        return after._replace(state=after.state._replace(y=state.y + 1.02 * (after.state.y - state.y)))


@pytest.mark.parametrize(
    ("scheme", "kind", "name", "texts"),
    [
        (ScaledK(), "langevin", "q(d(b1))", ("0.9986 I and 0.0018 else", "I")),
        (HalfFriction(), "langevin", "d(p)", ("0.98", "1")),
        pytest.param(StrongerY(), "index-1-additive", "u(b1)", ("1.02 I", "I"), marks=pytest.mark.slow),
    ],
)
def test_wrong_schemes_are_refuted_by_a_tree(scheme, kind, name, texts):
    """A correlation of the noise, a friction, an algebraic component."""
    told = {row.first.name: row.first.texts for row in orders(scheme, kind, 1).rows if row.verdict == "refuted"}

    assert told[name] == texts


@pytest.mark.parametrize("scheme", [FirstForAll(), NearForce()])
def test_wrong_places_and_noises_are_never_verified(scheme):
    """A force that is right at the origin, and noise that is right for one degree of freedom."""
    assert "verified" not in set(orders(scheme, "langevin").table.verdict)


def test_k_that_is_too_small_is_told_by_the_force_at_a_position_moved_by_noise():
    """Among the conditions that fail is that of F at q(b1); all are about the second integral of W by time."""
    probe = probe_of(ScaledK(), LANGEVIN, 1, 7)
    names = [each.name for each in Examined(probe).breaking("strong")]

    assert names == ["q(d(b1))", "f(q(b1))", "d(d(b1))", *names[3:]]


@pytest.mark.parametrize(
    ("scheme", "words"),
    [(Traced(), "a step does not commute with affine maps"), (RootFriction(), "weights are not a power series")],
)
def test_what_trees_cannot_tell_fails_a_premise(scheme, words):
    """A trace vanishes on all trees, and where there is no series a condition says nothing of each friction."""
    table = orders(scheme, "langevin").table

    assert "verified" not in set(table.verdict)
    assert all(words in premise for premise in table.premise)
    assert isinstance(scheme, RootFriction) or list(table.held) == list(table.of)


@pytest.mark.parametrize(
    ("wrong", "right", "kind", "component"),
    [
        pytest.param(
            *(StrongerY(), "stochastic-theta", "index-1-additive", "    y[0]  u(b1)\n"), marks=pytest.mark.slow
        ),
        (HalfFriction(), "baoab", "langevin", "    p[0]  p\n"),
        (ScaledK(), "quicsort", "langevin", "    q[0]  q(b1)\n"),
    ],
)
def test_the_file_of_a_condition_refutes_the_wrong_scheme_and_not_the_right_one(
    wrong, right, kind, component, tmp_path
):
    """The trees of an equation of index 1 and of Langevin dynamics are written as an equation that `matrix` runs."""
    report, file = orders(wrong, kind, 1), tmp_path / "problem.py"
    file.write_text(report.to_problem(report.failing[0]))

    assert component in file.read_text()
    assert "refuted" in set(verify(wrong, "counterexample", "strong", plugins=[file]).verdicts.verdict)
    assert not {"refuted", "error"} & set(verify(right, "counterexample", plugins=[file]).verdicts.verdict)


def test_where_forces_have_a_potential_no_file_is_written():
    """One line says what to do instead."""
    report = orders(ScaledK(), "langevin-gradient", 1)

    with pytest.raises(UsageError, match=r"langevin-gradient have no problem file; sdaeverify hunt wrong-scaled-k"):
        report.to_problem(report.failing[0])


def test_trees_of_langevin_dynamics_are_those_of_nystroem_with_friction():
    """Up to the weight 4 with one motion there are eleven, linear in the position, the friction and the noise."""
    trees = grow_nodes(LANGEVIN.nodes, 1, 4)
    names = [str(next(iter(each))) for each in told_apart(trees, frozenset({"d"}), 4).values()]

    assert names == ["b1", "q(p)", "f", "d(p)", "q(b1)", "d(b1)", "q(f)", "q(d(p))", "f(q(p))", "d(f)", "d(d(p))"]


def test_friction_is_told_by_its_power_alone():
    """f(q(d(b1))), q and d being linear, is d(f(q(b1))): one condition is about their sum."""
    trees = grow_nodes(LANGEVIN.nodes, 1, 7)
    sums = [
        each for each in told_apart(trees, frozenset({"d"}), 7).values() if str(next(iter(each))) == "d(f(q(b1)))"
    ]

    assert [sorted(map(str, each)) for each in sums] == [["d(f(q(b1)))", "f(q(d(b1)))"]]


def test_products_of_integrals_are_sums_of_integrals():
    """E u(a, b) c = E a b c, by Ito's formula for u(a, b) = I(a) I(b)."""
    b1, b2, moments = tree(1), tree(2), ExactMoments()
    some = [b1, b2, tree(0), tree(1, (b1,)), tree(2, (b1,)), tree(0, (b1,))]
    for a, b, c in ((a, b, c) for a in some for b in some for c in some):
        product = integral(tree(-2, (a, b), "u"))
        assert moments.mean_of_product((product, {c: 1})) == moments.mean((a, b, c))


def test_a_product_below_an_integral_lends_it_its_factors():
    """The integral of f(u(b1, b2)) is that of f(b1, b2)."""
    below = tree(-2, (tree(1), tree(2)), "u")
    assert integral(tree(0, (below,))) == {tree(0, (tree(1), tree(2))): 1}


@dataclass(frozen=True, kw_only=True, eq=False)
class Driven(Problem):
    """dx = f(x) dt + dW, a form of somebody else's: each component has its own Brownian motion."""

    drift: object
    start: object

    def initial(self, paths):
        """Return x at time 0."""
        return np.repeat(np.asarray(self.start)[:, None], paths, axis=1)

    def parts(self, x):
        """Return x."""
        return {"x": x}

    def ito(self):
        """Return the equation."""
        unit = np.eye(self.noise_dim)[..., None]
        return SDE(
            drift=self.drift, diffusion=lambda *_: unit, start=self.start, **self.shared_fields, source="driven"
        )

    @classmethod
    def tree_classes(cls):
        """Return the one class there is."""
        return (DrivenTrees(),)


class DrivenTrees(TreeClass):
    """Trees of f with leaves b."""

    name = "driven"
    nodes = (Node("f", "x", frozenset({"x"})), Node("b", "x", integral="dW", most=0))
    motions = 2

    def pose(self, grove):
        """Return one component for each tree, moved by its motion if it is noise."""
        n = len(grove.trees)

        def drift(t, x):
            z = np.concatenate([x - 0.5, np.ones((1, x.shape[1]))])
            moving = [np.prod(z[[*tree.kids, n]], axis=0) * (tree.node.name == "f") for tree in grove.trees]
            return np.array(moving)

        driven = np.array([[float(tree.motion == j) for j in range(2)] for tree in grove.trees])
        return Posed(driven_by(drift, np.full(n, 0.5)), [("x", i) for i in range(n)], np.ones(n), driven)

    def relatives(self, motions):
        """Return an equation in the plane, and a lifted one."""
        A, N = np.array([[1.0, 0.5, 0.2], [0.0, 1.0, -0.7]]), np.array([[0.45], [-0.7], [-1.0]])
        N -= np.linalg.pinv(A) @ (A @ N)
        below = driven_by(lambda t, x: np.sin(x[::-1]), A @ [0.1, 0.2, 0.3])
        above = driven_by(lambda t, x: np.linalg.pinv(A) @ np.sin((A @ x)[::-1]) + N * x[:1] ** 2, [0.1, 0.2, 0.3])
        return Relatives(below, above, {"x": (A, np.zeros((2, 1)))}, A)


def driven_by(drift, start):
    """Return the equation with a drift."""
    return Driven(drift=drift, start=start, noise_dim=len(start), horizon=1.0, source="mine")


@dataclass(frozen=True)
class DrivenHeun(Scheme):
    """Heun's method for the form, or with another weight of its second drift."""

    weight: float = 0.5

    name: ClassVar[str] = "driven-heun"
    form: ClassVar[type] = Driven
    claims: ClassVar[tuple[Claim, ...]] = (Claim(measure="weak", value=2.0, source="by its conditions"),)

    def step(self, problem, state, t, h, noise):
        """Make one step."""
        f = problem.drift(t, state)
        y = state + h * f + noise.dW
        return Step(state + h * ((1.0 - self.weight) * f + self.weight * problem.drift(t, y)) + noise.dW)


def test_a_form_of_ones_own_brings_its_trees():
    """A claim is verified for its class, a wrong coefficient is told, and other classes do not apply."""
    right = orders(DrivenHeun()).rows
    (wrong,) = orders(DrivenHeun(0.51), "driven").failing

    assert {row.verdict for row in right if row.kind == "driven"} == {"verified", "out_of_scope"}
    assert {row.verdict for row in right if row.kind != "driven"} == {"not_applicable"}
    assert (wrong.name, wrong.texts) == ("f(f)", ("0.51", "1/2"))


def test_an_unknown_class_is_told_with_those_of_the_form():
    """Whoever mistypes the name of a class sees the one of the form, too."""
    with pytest.raises(UsageError, match=r"unknown class 'drive'; did you mean driven\? \(known: driven, ode"):
        orders(DrivenHeun(), "drive")
