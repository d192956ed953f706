"""However what a scheme or a problem does is changed, evidence on what it did before is not found again."""

import os
import sys
from importlib import import_module, invalidate_caches

import pytest

from facade import (
    Entry,
    Task,
    behaviours,
    code,
    home_of,
    homes_of,
    lane_ingredients,
    opened_by,
    openings,
    problem_spec,
)
from sdaeverify import Settings
from sdaeverify.forms.sde import sde
from store.ways import PROBLEMS, SCHEMES, of_problem, of_scheme

SETTINGS = Settings(paths=40, block=40, levels=3)
OWN = ("mine", "neighbour", "odd_helper", "dependency")
PLAIN = {**of_problem({}).before, **of_scheme({}).before, "__init__.py": ""}
WAYS = {
    **{f"scheme: {name}": way for name, way in SCHEMES.items()},
    **{f"problem: {n}": w for n, w in PROBLEMS.items()},
}


@pytest.fixture
def put(tmp_path, monkeypatch):
    """Write a package, and return a function that writes its files and variables of the environment."""
    monkeypatch.syspath_prepend(str(tmp_path))
    monkeypatch.setattr(sys, "dont_write_bytecode", True)
    monkeypatch.setattr(sde, "apply", sde.apply)
    known = dict(os.environ)

    def write(files):
        for name, text in files.items():
            if name.isupper():
                os.environ[name] = text
            else:
                path = tmp_path / "mine" / name
                path.parent.mkdir(exist_ok=True)
                path.write_text(text)

    yield write
    forget()
    os.environ.clear()
    os.environ.update(known)


def forget():
    """Forget what was imported and read, as another process would."""
    invalidate_caches()
    for name in [name for name in sys.modules if name.partition(".")[0] in OWN]:
        del sys.modules[name]
    for remembered in (code._parse_home, home_of):
        remembered.cache_clear()


def determined():
    """Return what evidence is found by, as another process sees it: what is said and what is done."""
    forget()
    openings()
    register = import_module("mine.register")
    spec = problem_spec(register.PROBLEM)
    said = lane_ingredients(register.SCHEME, spec, SETTINGS, 0)
    (done,) = behaviours(Task(spec, (Entry(register.SCHEME, ()),), SETTINGS))
    assert done is not None
    homes = {*homes_of(type(register.SCHEME)), *homes_of(register.PROBLEM)} - {None}
    return said, done, opened_by(homes)


@pytest.mark.sweep
@pytest.mark.parametrize("way", WAYS.values(), ids=WAYS)
def test_no_change_goes_unnoticed(put, way):
    """What is left alone is found again in another process; of what was changed there is no evidence."""
    put({**PLAIN, **way.before})
    before = determined()
    assert determined() == before

    put(way.after)

    assert determined() != before
