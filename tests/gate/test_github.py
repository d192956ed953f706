"""Output for GitHub's runner."""

import inspect
from pathlib import Path

import pytest
from hypothesis import given
from hypothesis import strategies as st

from facade import MOST, annotations, data_text, fence, property_text, source_in
from sdaeverify import UsageError
from sdaeverify.measuring import Verdict

from .conftest import Plain, gated, result

PIECES = [*"a:,%]=|`\r\n\x00\x1b\u2028", "::", "::error::", "%0A::"]
TEXTS = st.lists(st.sampled_from(PIECES), max_size=12).map("".join)


def lines_of(gate, root):
    return list(annotations(gate, root))


@given(reason=TEXTS, quantity=TEXTS, kind=TEXTS, gone=TEXTS)
def test_untrusted_text_begins_no_command(reason, quantity, kind, gone):
    """Whatever a plugin's texts hold, a command is one line that begins as it must and has one message."""
    found = result(Verdict.REFUTED, scheme=Plain(kind), reason=reason, quantity=quantity)
    gate = gated(found, result(Verdict.INCONCLUSIVE, reason=reason), violations=(gone,))

    for line in annotations(gate, Path("/")):
        head, separator, rest = line.removeprefix("::").partition("::")
        assert line.splitlines() == [line]
        assert line.startswith(("::error ", "::warning "))
        assert separator
        assert all(pair.count("=") >= 1 for pair in head.split(" ", 1)[1].split(","))
        assert "%" not in rest.replace("%25", "").replace("%0A", "").replace("%0D", "")


def test_escapes():
    """Escapes are those that the runner undoes."""
    assert data_text("50 %\r\n") == "50 %25%0D%0A"
    assert property_text("C:\\a,b%") == "C%3A\\a%2Cb%25"


def test_place_of_a_scheme(tmp_path):
    """An annotation names file and line of the class relative to the root, and none where the scheme is elsewhere."""
    here = Path(__file__).parent
    line = inspect.getsourcelines(Plain)[1]
    (inside,) = lines_of(gated(result(Verdict.REFUTED)), here)
    (outside,) = lines_of(gated(result(Verdict.REFUTED)), tmp_path)

    assert inside.startswith(f"::error file=conftest.py,line={line},title=")
    assert outside.startswith("::error title=")


def test_source_of_an_installed_module(tmp_path):
    """The file of the checkout with the same text is meant, that which ends in the same names; another is none."""
    checkout, installed = tmp_path / "checkout", tmp_path / "lib" / "site-packages" / "mine" / "scheme.py"
    inside = checkout / ".venv" / "site-packages" / "mine" / "scheme.py"
    same = [checkout / "mine" / "scheme.py", checkout / "src" / "mine" / "scheme.py"]
    for file in (installed, inside, *same, checkout / "build" / "lib" / "mine" / "scheme.py"):
        file.parent.mkdir(parents=True)
        file.write_text("claims = ()\n")

    assert source_in(checkout, installed) == source_in(checkout, inside) == "mine/scheme.py"
    same[0].write_text("\n")
    assert source_in(checkout, installed) == source_in(checkout, inside) == "src/mine/scheme.py"
    same[1].write_text("\n")
    assert source_in(checkout, installed) == source_in(checkout, inside) == ""


def test_worst_first_and_not_too_many(tmp_path):
    """Errors come before warnings, and there are ten annotations at most."""
    doubts = [result(Verdict.INCONCLUSIVE, quantity=f"x{n}") for n in range(20)]
    lines = lines_of(gated(*doubts, result(Verdict.ERROR), result(Verdict.REFUTED)), tmp_path)

    assert len(lines) == MOST
    assert [line.split(" ")[0] for line in lines[:3]] == ["::error", "::error", "::warning"]
    assert "refuted" in lines[0]


def test_lock_leaves_room_for_claims(tmp_path):
    """Many lines of the lock file do not hide what is refuted."""
    lines = lines_of(gated(result(Verdict.REFUTED), violations=tuple(map(str, range(30)))), tmp_path)

    assert len(lines) == MOST // 2 + 1
    assert "refuted" in lines[-1]


def test_fence():
    """Commands are off inside of the fence, with a token that is new each time, and on again after an error."""
    written = []

    def fail():
        with fence(written.append):
            written.append("::error::inside")
            raise UsageError("wrong")

    for _ in range(2):
        with pytest.raises(UsageError):
            fail()

    first, inside, last, again = written[:4]
    token = first.removeprefix("::stop-commands::")
    assert len(token) == 32
    assert (inside, last) == ("::error::inside", f"::{token}::")
    assert again != first
