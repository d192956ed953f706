"""Ways of changing what a scheme or a problem does, by what is written before and afterwards.

What an object is or where it lies is the same to the three that evidence is kept by: parsed code, files that were
opened, and digests of what is done. There are ways for each of these, and ways round any one of them.
"""

from typing import NamedTuple

SCHEME = """
import os
from dataclasses import dataclass, make_dataclass
from pathlib import Path
from typing import ClassVar
import numpy as np
from sdaeverify import SDE, Claim, Scheme, Step
from sdaeverify.numerics import apply

HERE = Path(__file__).parent
{head}

class Mine(Scheme):
    name: ClassVar[str] = "mine"
    form: ClassVar[type] = SDE
    claims: ClassVar[tuple] = (Claim(measure="strong", value=0.5, source="nowhere"),)

    def step(self, problem, state, t, h, noise):
        factor = {factor}
        return Step(state + factor * h * problem.drift(t, state) + problem.diffused(t, state, noise.dW))
{tail}
"""
PROBLEM = """
import os
from pathlib import Path
import numpy as np
from sdaeverify import SDE, InvariantMean

HERE = Path(__file__).parent
A, NOISE = 0.5, 0.2
{head}

def mine(horizon: float = 1.0) -> SDE:
    factor = {factor}
    return SDE(
        drift=lambda t, x: factor * np.cos(x),
        diffusion=lambda t, x: NOISE * np.sin(x)[:, None] + 0.4,
        start=[1.0, 0.3],
        noise_dim=1,
        horizon=horizon,
        observables={{"x_1": lambda t, parts: parts["x"][0]}},
        truths=(InvariantMean(observable="x_1", value=0.0, source="nowhere"),),
        source="nowhere",
    )
"""
FIELDS = {"head": "", "factor": "1.0", "tail": ""}
PLAIN = {"head": "", "factor": "A"}
REGISTER = "from .scheme import Mine\nfrom .problem import mine\nSCHEME, PROBLEM = Mine(), mine\n"


class Way(NamedTuple):
    """A way of changing something.

    Attributes
    ----------
    before : dict of str to str
        Files below the folder of the package.
    after : dict of str to str
        Files that are written then; names in capitals are variables of the environment.
    """

    before: dict[str, str]
    after: dict[str, str]


def of_scheme(after, before=None, register="", **fields):
    """Return a way in which the scheme stays as it is written, and something else changes."""
    files = {"scheme.py": SCHEME.format(**{**FIELDS, **fields}), "register.py": REGISTER + register}
    return Way({**files, **(before or {})}, after)


def of_problem(after, before=None, **fields):
    """Return a way in which the problem stays as it is written, and something else changes."""
    return Way({"problem.py": PROBLEM.format(**{**PLAIN, **fields}), **(before or {})}, after)


def scheme(**fields):
    """Return the file of a scheme that is written otherwise."""
    return {"scheme.py": SCHEME.format(**{**FIELDS, **fields})}


def problem(**fields):
    """Return the file of a problem that is written otherwise."""
    return {"problem.py": PROBLEM.format(**{**PLAIN, **fields})}


def registering(line, **fields):
    """Return a way in which the registering module sets something to 1 or 2."""
    return of_scheme({"register.py": REGISTER + line.format("2.0")}, register=line.format("1.0"), **fields)


ONE, TWO = {"helper.py": "weight = 1.0\n"}, {"helper.py": "weight = 2.0\n"}
TABLE, OTHER = {"table.txt": "1.0 3.0\n"}, {"table.txt": "2.0 3.0\n"}
READ = 'float((HERE / "table.txt").read_text().split()[0])'
ENVIRONMENT = 'float(os.environ.get("WEIGHT", "1.0"))'
VARIABLE = {"WEIGHT": "2.0"}
BY_PATH = """
from importlib.util import module_from_spec, spec_from_file_location
found = spec_from_file_location("odd_helper", HERE / "helper.py")
odd = module_from_spec(found)
found.loader.exec_module(odd)
"""
MADE = """
def step(self, problem, state, t, h, noise):
    return Step(state + {} * h * problem.drift(t, state) + problem.diffused(t, state, noise.dW))
names = dict(name="mine", form=SDE, claims=Mine.claims, step=step)
Mine = {}
"""
DATACLASS = 'make_dataclass("Mine", [], bases=(Scheme,), namespace=names, frozen=True)'

LATER = "def weight(t):\n    return 2.0 if 0.41 < t < 0.43 else 1.0\n"
SOONER = "def weight(t):\n    return 1.0\n"

SCHEMES = {
    "formula": of_scheme(scheme(factor="2.0")),
    "helper imported by its path": of_scheme(TWO, ONE, head=BY_PATH, factor="odd.weight"),
    "helper that is executed": of_scheme(TWO, ONE, head='exec((HERE / "helper.py").read_text())', factor="weight"),
    "neighbour": of_scheme(
        {"../neighbour.py": "weight = 2.0"},
        {"../neighbour.py": "weight = 1.0"},
        head="import neighbour",
        factor="neighbour.weight",
    ),
    "base class elsewhere": of_scheme(
        {"../neighbour.py": "class Base:\n    a = 2.0"},
        {"../neighbour.py": "class Base:\n    a = 1.0"},
        head="from neighbour import Base",
        factor="Base.a",
    ),
    "data read as it is imported": of_scheme(OTHER, TABLE, head=f"weight = {READ}", factor="weight"),
    "data read in each step": of_scheme(OTHER, TABLE, factor=READ),
    "data outside the package": of_scheme(
        {"../table.txt": "2.0 3.0"}, {"../table.txt": "1.0 3.0"}, factor=READ.replace("HERE", "HERE.parent")
    ),
    "environment by a composed name": of_scheme(VARIABLE, factor='float(os.environ.get("WEI" + "GHT"[:3], "1.0"))'),
    "environment late in a run": of_scheme(VARIABLE, factor=f"{ENVIRONMENT} if t > 0.97 else 1.0"),
    "function of the framework that is replaced": registering(
        "import sdaeverify.forms.sde.sde as sde\nfrom sdaeverify.numerics import apply\n"
        "sde.apply = lambda B, w: {} * apply(B, w)"
    ),
    "make_dataclass from data": of_scheme(OTHER, TABLE, tail=MADE.format(READ, DATACLASS)),
    "neighbour within a window": of_scheme(
        {"../neighbour.py": LATER},
        {"../neighbour.py": SOONER},
        head="from neighbour import weight",
        factor="weight(t)",
    ),
}
PROBLEMS = {
    "drift": of_problem(problem(factor="2.0")),
    "data of the problem": of_problem(OTHER, TABLE, factor=READ),
    "global of the problem": of_problem(
        {"register.py": "from . import problem\nproblem.NOISE = 0.7\n" + REGISTER}, {}
    ),
    "shifted drift by a variable, far out": of_problem(
        VARIABLE, factor=f"np.where(os.environ.get('WEIGHT'), {ENVIRONMENT}, 1.0)"
    ),
}
