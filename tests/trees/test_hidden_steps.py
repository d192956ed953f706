"""Steps that are wrong where weights are not looked at: at short steps, among other paths, in a band of the noise."""

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any, ClassVar

import numpy as np
import pytest

from facade import EulerMaruyama, HalfExplicitEuler, HeunAdditive
from sdaeverify import Scheme
from sdaeverify.measuring import Verdict
from sdaeverify_orders import orders

# No node of a rule is between this and the next 0.15 standard deviations, and none of a few random points.
LOW = 0.35


def short(x: Any, h: float, z: Any) -> Any:
    """Return whether the step is shorter than 1e-4."""
    return np.full(x.shape[1], h < 1e-4)


def crowded(x: Any, h: float, z: Any) -> Any:
    """Return whether nearly all of many paths have states and noise of their own."""
    distinct = min(np.unique(part).size for part in (x[0], z))
    return np.full(x.shape[1], distinct > 0.9 * x.shape[1] > 20)


def banded(x: Any, h: float, z: Any) -> Any:
    """Return whether the first increment is in a range with 6 per cent of its law, or less."""
    return (z > LOW) & (z < LOW + 0.15)


def where(condition: Callable[..., Any], base: type[Scheme], share: float = 0.05) -> Scheme:
    """Return a scheme that is off by a share of the noise where a condition holds."""

    def prepare(self: Scheme, problem: Any, h: float) -> Callable[..., Any]:
        right = base.prepare(self, problem, h)

        def stepper(state: Any, t: float, noise: Any) -> Any:
            step, off = right(state, t, noise), condition(state, h, noise.dW[0] / np.sqrt(h))
            return step._replace(state=step.state + share * off * problem.diffused(t, state, noise.dW))

        return stepper

    own = {"name": f"{condition.__name__}-{base.name}", "prepare": prepare, "__module__": __name__}
    return dataclass(frozen=True)(type("Where", (base,), own))()


@pytest.mark.parametrize("condition", [short, crowded, banded])
@pytest.mark.parametrize(("base", "kind"), [(EulerMaruyama, "scalar"), (HeunAdditive, "additive")])
def test_noise_that_is_too_large_there_is_not_verified_for_a_class(condition, base, kind):
    """No claim of the class is verified."""
    table = orders(where(condition, base), kind, motions=2).table

    assert Verdict.VERIFIED not in set(table.verdict)


@pytest.mark.parametrize("condition", [short, crowded, banded])
def test_the_same_scheme_without_a_fault_is_verified(condition):
    """The condition alone changes nothing."""
    assert set(orders(where(condition, EulerMaruyama, 0.0), "scalar").table.verdict) == {Verdict.VERIFIED}


class LouderAmongMany(HalfExplicitEuler):
    """The half-explicit scheme with noise that is 5 per cent too large among many different paths."""

    name: ClassVar[str] = "louder-among-many"
    share: ClassVar[float] = 0.05

    def step(self, problem: Any, state: Any, t: float, h: float, noise: Any) -> Any:
        """Make one step."""
        distinct = np.unique(state.r[0]).size > 0.9 * state.r.shape[1] > 20
        return super().step(problem, state, t, h, noise._replace(dW=(1.0 + self.share * distinct) * noise.dW))


class LouderInBand(LouderAmongMany):
    """The same in a band of the noise."""

    name: ClassVar[str] = "louder-in-band"

    def step(self, problem: Any, state: Any, t: float, h: float, noise: Any) -> Any:
        """Make one step."""
        z = noise.dW / np.sqrt(h)
        louder = 1.0 + self.share * ((z > LOW) & (z < LOW + 0.15))
        return HalfExplicitEuler.step(self, problem, state, t, h, noise._replace(dW=louder * noise.dW))


@pytest.mark.long
@pytest.mark.parametrize("cls", [LouderAmongMany, LouderInBand])
def test_random_members_are_run_as_problems_are(cls: type[LouderAmongMany]) -> None:
    """A step that is wrong there has no claim about its form verified; the right twin has all."""
    wrong = orders(cls(truncation="none"), "HolonomicSDAE").table
    assert Verdict.VERIFIED not in set(wrong.verdict)
    right = orders(type("Right", (cls,), {"name": "right", "share": 0.0})(truncation="none"), "HolonomicSDAE").table
    assert set(right.verdict) == {Verdict.VERIFIED}
