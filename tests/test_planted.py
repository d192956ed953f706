"""Planted bugs: what they must say, and how they are registered."""

import sys
from typing import ClassVar

import pytest

from facade import Planted, load_registry
from sdaeverify import SDE, Claim, Scheme, SchemeError
from sdaeverify.errors import PluginError

PLUGIN = """
from dataclasses import dataclass, field
from typing import ClassVar
from sdaeverify import SDE, Claim, Scheme, hookimpl
from sdaeverify_lab import Planted

@dataclass(frozen=True)
class Wrong(Scheme):
    factor: float = 1.0
    name: ClassVar[str] = "planted-wrong"
    form: ClassVar[type] = SDE
    claims: ClassVar[tuple] = (Claim(measure="strong", value=1.0, source="made up"),)

    def step(self, problem, state, t, h, noise):
        raise NotImplementedError

@hookimpl
def sdaeverify_planted():
    return [Planted(bug="wrong", scheme=Wrong(2.0), problem="gbm[a=-1]")]
"""
CLAIM = Claim(measure="strong", value=1.0, source="made up")


class Wrong(Scheme):
    name: ClassVar[str] = "planted-wrong"
    form: ClassVar[type] = SDE
    claims: ClassVar[tuple] = (CLAIM,)

    def step(self, problem, state, t, h, noise):
        raise NotImplementedError


class Plain(Wrong):
    name: ClassVar[str] = "plain"


class Modest(Wrong):
    claims: ClassVar[tuple] = ()


@pytest.fixture
def load(tmp_path):
    """Write plugin files and load them beside the installed plugins."""

    def put(*texts):
        files = []
        for number, text in enumerate(texts):
            files.append(tmp_path / f"plugin_{number}.py")
            files[-1].write_text(text)
        return load_registry(files, environ={})

    yield put
    for name in [name for name in sys.modules if name.startswith("sdaeverify_file_")]:
        del sys.modules[name]


@pytest.mark.parametrize(
    ("bug", "scheme", "reason"),
    [
        ("  ", Wrong(), "needs a description of the mistake"),
        ("wrong", Plain(), "must begin with planted-, got 'plain'"),
        ("wrong", Modest(), "has no claim that could be refuted"),
    ],
)
def test_unusable_bug(bug, scheme, reason):
    """A bug has words, a name that passes for no other and a claim."""
    with pytest.raises(SchemeError, match=reason):
        Planted(bug=bug, scheme=scheme, problem="gbm")


def test_registered_by_label_and_not_among_the_schemes(load):
    """A planted bug is found under its scheme's and its problem's label, and is no scheme to choose from."""
    registry = load(PLUGIN)

    planted = registry.things("sdaeverify_planted")
    assert planted["planted-wrong[factor=2] on gbm[a=-1]"].bug == "wrong"
    assert "planted-wrong" not in registry.schemes
    assert (registry.plugins[-1].schemes, registry.plugins[-1].further) == (0, (("sdaeverify_planted", 1),))
    assert list(planted) == sorted(planted)


@pytest.mark.parametrize(
    ("change", "reason"),
    [
        (("return [", "return [Wrong(), "), "to be Planted, got an object of type Wrong"),
        (("return [", "return [Planted, "), "to be Planted, got the class Planted"),
        (("return [", "return None and ["), "returned None, expected an iterable"),
        (('problem="gbm[a=-1]"', 'problem="gbm[a"'), "cannot read 'gbm\\[a'"),
        (("factor: float = 1.0", "factor: float"), "has no default"),
        (('name: ClassVar[str] = "planted-wrong"', 'name: ClassVar[str] = "planted-wrong x"'), "name of a scheme"),
        (("(2.0)", "(lambda: 0)"), "factor of scheme 'planted-wrong' expects a number"),
    ],
)
def test_unusable_plugin(load, change, reason):
    """A planted scheme is checked as any other, its problem's label is read."""
    with pytest.raises(PluginError, match=reason):
        load(PLUGIN.replace(*change))


def test_registered_twice(load):
    """One scheme on one problem is one bug, within a plugin and between two."""
    twice = PLUGIN.replace("return [", "return 2 * [")

    with pytest.raises(PluginError, match="is registered twice by this plugin"):
        load(twice)
    with pytest.raises(PluginError, match="is already registered by plugin plugin_0"):
        load(PLUGIN, PLUGIN)
