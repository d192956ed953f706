"""Where claims are written."""

import inspect
from dataclasses import replace
from pathlib import Path

from sdaeverify.gate.writers.github import claim_place

from . import conftest
from .conftest import SHARP, Fussy, Plain

SOURCE = inspect.getsource(conftest).splitlines()


def text_at(place):
    file, line = place
    assert file == Path(conftest.__file__)
    return SOURCE[line - 1]


def test_claim_of_the_module():
    """A claim that is written beside the class is found by its measure, value and source."""
    assert text_at(claim_place(Plain(), SHARP)).startswith("SHARP = Claim(")
    assert text_at(claim_place(Fussy(), conftest.WEAKER)).startswith("WEAKER = Claim(")


def test_claim_of_elsewhere():
    """A claim that is not written in the file of its scheme is shown at the class."""
    assert text_at(claim_place(Plain(), replace(SHARP, source="elsewhere"))) == "class Plain(Scheme):"
    assert text_at(claim_place(Fussy(), None)) == "class Fussy(Plain):"


def test_class_comes_first(tmp_path, monkeypatch):
    """A claim within the class counts before one that is alike outside of it."""
    file = tmp_path / "mine.py"
    file.write_text(
        'A = Claim(measure="sharp", value=1)\nclass Plain:\n    claims = (x.Claim(measure="sharp", value=1.0),)\n'
    )
    monkeypatch.setitem(__import__("sys").modules, Plain.__module__, type("Module", (), {"__file__": str(file)}))

    assert claim_place(Plain(), SHARP) == (file, 3)


def test_no_source(monkeypatch):
    """A scheme whose source cannot be read has no place."""
    monkeypatch.setitem(__import__("sys").modules, Plain.__module__, type("Module", (), {"__file__": "/nowhere.py"}))

    assert claim_place(Plain(), SHARP) is None
