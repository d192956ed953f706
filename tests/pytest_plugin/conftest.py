"""A project with a policy and schemes whose claims hold, do not hold, cannot be decided or measured."""

import pytest

# Loaded here, so that runs of pytest inside a test find it all imported.
from sdaeverify.registry.load import load_registry
from sdaeverify.testing import claims  # noqa: F401 - for the same reason

SCHEMES = '''
import time
from dataclasses import dataclass
from typing import ClassVar

from sdaeverify import SDE, Claim, Scheme, Step, hookimpl


def strong(value):
    return (Claim(measure="strong", value=value, source="a theorem"),)


@dataclass(frozen=True)
class Right(Scheme):
    """Euler-Maruyama."""

    name: ClassVar[str] = "right"
    form: ClassVar[type] = SDE
    claims: ClassVar = strong(0.5)

    def step(self, problem, state, t, h, noise):
        return Step(state + h * problem.drift(t, state) + problem.diffused(t, state, noise.dW))


@dataclass(frozen=True)
class Wrong(Right):
    """The same with a claim that is too high."""

    name: ClassVar[str] = "wrong"
    claims: ClassVar = strong(1.0)


@dataclass(frozen=True)
class Vague(Right):
    """The same with a claim that nothing can decide."""

    name: ClassVar[str] = "vague"
    claims: ClassVar = strong("sometimes")


@dataclass(frozen=True)
class Raising(Right):
    """A scheme that cannot make a step."""

    name: ClassVar[str] = "raising"

    def step(self, problem, state, t, h, noise):
        raise RuntimeError("out of \\x1b[31msteps")


@dataclass(frozen=True)
class Hanging(Right):
    """A scheme that never makes its step."""

    name: ClassVar[str] = "hanging"

    def step(self, problem, state, t, h, noise):
        time.sleep(300.0)


@dataclass(frozen=True)
class Breaching(Right):
    """A scheme that moves where nothing does."""

    name: ClassVar[str] = "breaching"

    def step(self, problem, state, t, h, noise):
        return Step(1.01 * state)


@hookimpl
def sdaeverify_schemes():
    return [Right(), Wrong(), Vague(), Raising(), Hanging(), Breaching()]
'''
# Plugins that take seconds to load in every run.
LEAN = ("-p", "no:hypothesispytest", "-p", "no:benchmark")
POLICY = """
[tool.sdaeverify]
plugins = ["schemes.py"]
schemes = [{schemes}]
problems = ["gbm"]
tier = "smoke"
{further}
"""


@pytest.fixture(scope="session", autouse=True)
def _imported():
    load_registry()


@pytest.fixture
def project(pytester):
    """Write the project and return a function that runs pytest in it."""
    pytester.makepyfile(schemes=SCHEMES)

    def run(*arguments, schemes=("right", "wrong", "vague", "raising"), further=""):
        named = ", ".join(f'"{name}"' for name in schemes)
        pytester.makepyprojecttoml(POLICY.format(schemes=named, further=further))
        return pytester.runpytest_inprocess("--sdaeverify", *LEAN, *arguments)

    return run
