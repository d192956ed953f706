"""The contract of a step refuses schemes that break it, one by one."""

import dataclasses
import random
from collections.abc import Callable
from dataclasses import dataclass
from typing import ClassVar

import numpy as np
import pytest

from conformance import test_scheme_contract as contract
from conformance.cells import Cell, draw, spread, step
from sdaeverify.arrays import Array
from sdaeverify.errors import SchemeError
from sdaeverify.forms import SDE
from sdaeverify.noise import Increment
from sdaeverify.registry import Registry
from sdaeverify.scheme import Claim, Scheme, Step
from sdaeverify_problems.gbm import gbm

Rule = Callable[[Array, float, Increment], Array | Step]


@dataclass(frozen=True)
class Planted(Scheme):
    """A scheme that is one rule."""

    rule: Rule = lambda x, h, noise: x + h * x + noise.dW

    name: ClassVar[str] = "planted"
    form: ClassVar[type[SDE]] = SDE
    source: ClassVar[str] = "made up"

    @property
    def label(self) -> str:
        return "planted"

    def step(self, problem: SDE, state: Array, t: float, h: float, noise: Increment) -> Step:
        """Make one step."""
        new = self.rule(state, h, noise)
        return new if isinstance(new, Step) else Step(new)


def writes(x: Array, h: float, noise: Increment) -> Array:
    x += noise.dW
    return x.copy()


PLANTED: dict[str, tuple[Rule, type[Exception], str]] = {
    "draws numbers": (lambda x, h, n: x + n.dW + random.random(), AssertionError, "a_step_is_a_function"),
    "writes into its state": (writes, AssertionError, "a_step_leaves_its_inputs_alone"),
    "needs to write": (writes, ValueError, "a_step_accepts_read_only_inputs"),
    "hands on the noise": (lambda x, h, n: n.dW, AssertionError, "a_new_state_is_no_view_of_the_noise"),
    "sees the mean": (lambda x, h, n: x + n.dW + 1e-14 * x.mean(), AssertionError, "paths_do_not_see"),
    "knows its place": (lambda x, h, n: x + n.dW + np.arange(x.size), AssertionError, "paths_can_be_reordered"),
    "returns one path": (lambda x, h, n: (x + n.dW)[:, :1], SchemeError, "a_step_returns_a_state_like"),
    "is deaf": (lambda x, h, n: x + h, AssertionError, "a_step_uses_the_increment"),
    "is deaf on one path": (
        lambda x, h, n: x + h + n.dW * (x > x.min()),
        AssertionError,
        "a_step_uses_the_increment",
    ),
    "is deaf and fails": (
        lambda x, h, n: Step(x + h, failed=np.ones(x.shape[1], dtype=bool)),
        AssertionError,
        "a_step_uses_the_increment",
    ),
    "hears more": (lambda x, h, n: x + n.dW + n.H, AssertionError, "a_scheme_uses_the_noise_it_declares"),
}


def check(cell: Cell, test: str) -> None:
    """Run the one contract test of this name on a cell."""
    h, paths = cell.problem.horizon / 64, contract.PATHS
    (function,) = [f for name, f in vars(contract).items() if name.startswith(f"test_{test}")]
    state, noise = spread(Planted(), cell.problem, paths), draw(1, paths, h, block=paths)
    given = {
        "cell": lambda: cell,
        "h": lambda: h,
        "state": lambda: state,
        "noise": lambda: noise,
        "made": lambda: step(cell, state, h, noise),
    }
    names = function.__code__.co_varnames[: function.__code__.co_argcount]
    function(**{name: given[name]() for name in names})


@pytest.mark.parametrize("fault", PLANTED)
def test_a_planted_fault_is_noticed(fault: str) -> None:
    """A scheme with one fault fails the test of this fault."""
    rule, error, test = PLANTED[fault]

    with pytest.raises(error):
        check(Cell(Planted(rule), gbm(), fault), test)


@pytest.mark.parametrize("test", sorted({test for _, _, test in PLANTED.values()}))
def test_the_same_scheme_without_fault_passes(test: str) -> None:
    """The rule that the faults were planted in passes every test."""
    check(Cell(Planted(), gbm(), "without fault"), test)


CLAIM = Claim(measure="strong", value=1.0, source="made up")


@pytest.mark.parametrize("change", [{"source": " "}, {"measure": "strnog"}])
def test_claims_that_nobody_can_verify_are_noticed(change: dict[str, object], registry: Registry) -> None:
    """A claim without source or with an unknown measure fails."""

    @dataclass(frozen=True)
    class Claiming(Planted):
        claims: ClassVar[tuple[Claim, ...]] = (dataclasses.replace(CLAIM, **change),)

    with pytest.raises(AssertionError):
        contract.test_claims_can_be_verified(Claiming(), registry, set())
