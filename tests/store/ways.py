"""Ways of changing what a scheme or a problem does, by what is written before and afterwards."""

from typing import NamedTuple

SCHEME = """
import json, os, sys
from dataclasses import dataclass, make_dataclass
from enum import Enum
from functools import partial
from pathlib import Path
from types import SimpleNamespace
from typing import ClassVar
import numpy as np
from sdaeverify import SDE, Claim, Scheme, Step
from sdaeverify.numerics import apply

HERE = Path(__file__).parent
{head}

@dataclass(frozen=True)
class Mine(Scheme):
    {field}
    name: ClassVar[str] = "mine"
    form: ClassVar[type] = SDE
    claims: ClassVar[tuple] = (Claim(measure="strong", value=0.5, source="nowhere"),)
    {body}

    def step(self, problem, state, t, h, noise):
        factor = {factor}
        return Step(state + factor * h * problem.drift(t, state) + problem.diffused(t, state, noise.dW))
{tail}
"""
PROBLEM = """
import os
from pathlib import Path
import numpy as np
from sdaeverify import SDE, Control, InvariantMean, Moment, Pathwise

HERE = Path(__file__).parent
A, NOISE = 0.5, {noise}
{head}

def mine(horizon: float = {horizon}) -> SDE:
    factor = {factor}
    return SDE(
        drift=lambda t, x: factor * np.cos(x),
        diffusion=lambda t, x: NOISE * np.sin(x)[:, None] + 0.4,
        start=[{start}, 0.3],
        noise_dim=1,
        horizon=horizon,
        observables={{"x_1": lambda t, parts: {observed} * parts["x"][0]}},
        truths=({truth},),
        source="nowhere",
    )
"""
FIELDS = {"head": "", "factor": "1.0", "field": "pass", "body": "", "tail": ""}
PLAIN = {
    "head": "",
    "factor": "A",
    "noise": "0.2",
    "horizon": "1.0",
    "start": "1.0",
    "observed": "1.0",
    "truth": 'InvariantMean(observable="x_1", value=0.0, source="nowhere")',
}
REGISTER = "from .scheme import Mine\nfrom .problem import mine\nSCHEME, PROBLEM = Mine(), mine\n"
MOMENT = 'Moment(observable="x_1", value=lambda t: {} * t, source="nowhere")'
PATH = """Pathwise(
    start=lambda P: np.outer([1.0, 0.3], np.ones(P)),
    advance=lambda z, t, h, noise: z + {} * noise.dW,
    parts=lambda t, z: {{"x": z}},
    source="nowhere",
)"""


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
FACTORY = "def made(weight):\n    def f():\n        return weight\n    return f\n"
MADE = """
def step(self, problem, state, t, h, noise):
    return Step(state + {} * h * problem.drift(t, state) + problem.diffused(t, state, noise.dW))
names = dict(name="mine", form=SDE, claims=Mine.claims, step=step)
Mine = {}
"""
DATACLASS = 'make_dataclass("Mine", [], bases=(Scheme,), namespace=names, frozen=True)'
TYPE = 'dataclass(frozen=True)(type("Mine", (Scheme,), names))'

SCHEMES = {
    "formula": of_scheme(scheme(factor="2.0")),
    "default of a parameter": of_scheme(
        scheme(field="a: float = 2.0", factor="self.a"), field="a: float = 1.0", factor="self.a"
    ),
    "class variable": of_scheme(
        scheme(body="a: ClassVar[float] = 2.0", factor="self.a"),
        body="a: ClassVar[float] = 1.0",
        factor="self.a",
    ),
    "helper": of_scheme(TWO, ONE, head="from . import helper", factor="helper.weight"),
    "helper by name": of_scheme(TWO, ONE, head="from .helper import weight", factor="weight"),
    "all of a helper": of_scheme(TWO, ONE, head="from .helper import *", factor="weight"),
    "helper of a helper": of_scheme(
        TWO, {**ONE, "between.py": "from .helper import weight"}, head="from .between import weight", factor="weight"
    ),
    "helper imported late": of_scheme(
        TWO, ONE, head="from importlib import import_module", factor='getattr(import_module("mine.helper"), "weight")'
    ),
    "helper imported by its name": of_scheme(
        TWO,
        ONE,
        head='from importlib import import_module\nhelper = import_module("mine.helper")',
        factor="helper.weight",
    ),
    "helper imported by its path": of_scheme(TWO, ONE, head=BY_PATH, factor="odd.weight"),
    "helper that is executed": of_scheme(TWO, ONE, head='exec((HERE / "helper.py").read_text())', factor="weight"),
    "neighbour": of_scheme(
        {"../neighbour.py": "weight = 2.0"},
        {"../neighbour.py": "weight = 1.0"},
        head="import neighbour",
        factor="neighbour.weight",
    ),
    "neighbour by its name": of_scheme(
        {"../neighbour.py": "weight = 2.0"},
        {"../neighbour.py": "weight = 1.0"},
        factor='__import__("neighbour").weight',
    ),
    "base class elsewhere": of_scheme(
        {"../neighbour.py": "class Base:\n    a = 2.0"},
        {"../neighbour.py": "class Base:\n    a = 1.0"},
        head="from neighbour import Base",
        factor="Base.a",
    ),
    "data read as it is imported": of_scheme(OTHER, TABLE, head=f"weight = {READ}", factor="weight"),
    "data read in each step": of_scheme(OTHER, TABLE, factor=READ),
    "array of data": of_scheme(OTHER, TABLE, head='table = np.loadtxt(HERE / "table.txt")', factor="table[0]"),
    "data in JSON": of_scheme(
        {"table.json": '{"a": 2.0}'},
        {"table.json": '{"a": 1.0}'},
        head='table = json.loads((HERE / "table.json").read_text())',
        factor='table["a"]',
    ),
    "data outside the package": of_scheme(
        {"../table.txt": "2.0 3.0"}, {"../table.txt": "1.0 3.0"}, factor=READ.replace("HERE", "HERE.parent")
    ),
    "data read by the constructor": of_scheme(
        OTHER,
        TABLE,
        body=f'def __post_init__(self):\n        object.__setattr__(self, "read", {READ})\n',
        factor="self.read",
    ),
    "environment as it is imported": of_scheme(VARIABLE, head=f"weight = {ENVIRONMENT}", factor="weight"),
    "environment in each step": of_scheme(VARIABLE, factor=ENVIRONMENT),
    "environment by a composed name": of_scheme(VARIABLE, factor='float(os.environ.get("WEI" + "GHT"[:3], "1.0"))'),
    "environment late in a run": of_scheme(VARIABLE, factor=f"{ENVIRONMENT} if t > 0.97 else 1.0"),
    "global of its module": registering(
        "from . import scheme\nscheme.weight = {}", head="weight = 1.0", factor="weight"
    ),
    "class variable set elsewhere": registering("Mine.a = {}", body="a: ClassVar[float] = 1.0", factor="self.a"),
    "attribute of the instance": registering(
        'object.__setattr__(SCHEME, "a", {})', body="a: ClassVar[float] = 1.0", factor="self.a"
    ),
    "parameter of the instance": registering("SCHEME = Mine({})", field="a: float = 3.0", factor="self.a"),
    "entry of a table": registering(
        'from . import scheme\nscheme.table["a"] = {}', head='table = {"a": 1.0}', factor='table["a"]'
    ),
    "element of a list": registering("from . import scheme\nscheme.row[0] = {}", head="row = [1.0]", factor="row[0]"),
    "element of an array": registering(
        "from . import scheme\nscheme.row[0] = {}", head="row = np.ones(3)", factor="row[0]"
    ),
    "default of a function": registering(
        "from . import scheme\nscheme.f.__defaults__ = ({},)", head="def f(a=1.0):\n    return a", factor="f()"
    ),
    "default of a keyword": registering(
        'from . import scheme\nscheme.f.__kwdefaults__["a"] = {}', head="def f(*, a=1.0):\n    return a", factor="f()"
    ),
    "attribute of a function": registering(
        "from . import scheme\nscheme.f.a = {}", head="def f():\n    return f.a", factor="f()"
    ),
    "function that is replaced": registering(
        "from . import scheme\nscheme.f = lambda: {}", head="def f():\n    return 1.0", factor="f()"
    ),
    "method that is replaced": registering("Mine.f = lambda self: {}", factor="self.f()"),
    "property that is replaced": registering("Mine.a = property(lambda self: {})", factor="self.a"),
    "function of the framework that is replaced": registering(
        "import sdaeverify.forms.sde.sde as sde\nfrom sdaeverify.numerics import apply\n"
        "sde.apply = lambda B, w: {} * apply(B, w)"
    ),
    "closure": registering(
        "from . import scheme\nscheme.f = scheme.made({})", head=FACTORY + "f = made(1.0)", factor="f()"
    ),
    "closure in its own module": of_scheme(
        scheme(head=FACTORY + "f = made(2.0)", factor="f()"), head=FACTORY + "f = made(1.0)", factor="f()"
    ),
    "partial": registering(
        "from . import scheme\nscheme.f = partial(float, {})\n".replace("\n", "\nfrom functools import partial\n", 1),
        head="f = float",
        factor="f()",
    ),
    "bound method": registering("from . import scheme\nscheme.f = ({}).__float__", head="f = float", factor="f()"),
    "namespace": registering(
        "from . import scheme\nscheme.c.a = {}", head="c = SimpleNamespace(a=1.0)", factor="c.a"
    ),
    "enumeration": of_scheme(
        scheme(head="class E(Enum):\n    a = 2.0", factor="E.a.value"),
        head="class E(Enum):\n    a = 1.0",
        factor="E.a.value",
    ),
    "nested tuple": registering(
        "from . import scheme\nscheme.rows = ((1, ({},)),)", head="rows = ((1, (1.0,)),)", factor="rows[0][1][0]"
    ),
    "make_dataclass": of_scheme(scheme(tail=MADE.format("2.0", DATACLASS)), tail=MADE.format("1.0", DATACLASS)),
    "type": of_scheme(scheme(tail=MADE.format("2.0", TYPE)), tail=MADE.format("1.0", TYPE)),
    "make_dataclass from data": of_scheme(OTHER, TABLE, tail=MADE.format(READ, DATACLASS)),
    "code made of a text": registering(
        'from . import scheme\nexec("def f(): return {}", vars(scheme))', head="f = None", factor="f()"
    ),
}
LATER = {"helper.py": "def weight(t):\n    return 2.0 if 0.41 < t < 0.43 else 1.0\n"}
SOONER = {"helper.py": "def weight(t):\n    return 1.0\n"}
SCHEMES |= {
    "helper within a window": of_scheme(LATER, SOONER, head="from .helper import weight", factor="weight(t)"),
    "helper within a window, by its module": of_scheme(
        LATER, SOONER, head="from . import helper", factor="helper.weight(t)"
    ),
    "neighbour within a window": of_scheme(
        {"../neighbour.py": LATER["helper.py"]},
        {"../neighbour.py": SOONER["helper.py"]},
        head="from neighbour import weight",
        factor="weight(t)",
    ),
}
PROBLEMS = {
    "drift": of_problem(problem(factor="2.0")),
    "diffusion": of_problem(problem(noise="0.3")),
    "start": of_problem(problem(start="1.25")),
    "horizon": of_problem(problem(horizon="2.0")),
    "observable": of_problem(problem(observed="2.0")),
    "stationary mean": of_problem(problem(truth=PLAIN["truth"].replace("0.0", "0.1"))),
    "moment": of_problem(problem(truth=MOMENT.format("2.0")), truth=MOMENT.format("1.0")),
    "path": of_problem(problem(truth=PATH.format("2.0")), truth=PATH.format("1.0")),
    "data of the problem": of_problem(OTHER, TABLE, factor=READ),
    "environment of the problem": of_problem(VARIABLE, factor=ENVIRONMENT),
    "data of a truth": of_problem(OTHER, TABLE, truth=MOMENT.format(READ)),
    "global of the problem": of_problem(
        {"register.py": "from . import problem\nproblem.NOISE = 0.7\n" + REGISTER}, {}
    ),
    "helper of the problem": of_problem(TWO, ONE, head="from .helper import weight", factor="weight"),
    "shifted drift by a variable, far out": of_problem(
        VARIABLE, factor=f"np.where(os.environ.get('WEIGHT'), {ENVIRONMENT}, 1.0)"
    ),
}
