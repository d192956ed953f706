"""The examples in the files of the clients, as an author would copy them."""

import re
import shutil
import sys

import numpy as np
import pytest

from facade import gbm
from sdaeverify_problems.curves.ellipse import ellipse
from sdaeverify_problems.levy_area import levy_area
from sdaeverify_wire.scheme import scheme_of
from wire.compiling import CLIENTS, need


def copied(name, mark, folder):
    """Return the lines of the example in the head of a client, without the mark of its comments."""
    head = (CLIENTS / name).read_text().partition("With ")[0]
    lines = [line.removeprefix(mark) for line in head.splitlines() if line.startswith(mark)]
    shutil.copy(CLIENTS / name, folder)
    return [re.sub(r"^ {4}", "", line) if mark == "" else line for line in lines if line.startswith("    ") or mark]


def python_example(folder):
    """Return the example in Python as a command."""
    (folder / "my_euler.py").write_text("\n".join(copied("sdaeverify_client.py", "", folder)))
    return [sys.executable, str(folder / "my_euler.py")]


def octave_example(folder):
    """Return the example in Octave as a command: a script defines a function before it is used."""
    first, *function = copied("sdaeverify.m", "  %   ", folder)
    # A file that begins with a function is taken for that function and not for a script.
    (folder / "my_euler.m").write_text("\n".join(["1;", *function, first]))
    return [need("octave-cli"), "--no-gui", "--norc", "-q", "-p", str(folder), str(folder / "my_euler.m")]


def r_example(folder):
    """Return the example in R as a command."""
    lines = copied("sdaeverify.R", "#   ", folder)
    lines[0] = f'source("{folder / "sdaeverify.R"}")'
    (folder / "my_euler.R").write_text("\n".join(lines))
    return [need("Rscript"), "--vanilla", str(folder / "my_euler.R")]


@pytest.mark.parametrize("example", [python_example, octave_example, r_example])
@pytest.mark.parametrize("problem", [gbm(), ellipse()], ids=["one component", "two components"])
def test_the_example_of_a_client_is_eulers_method(example, problem, tmp_path):
    """It makes Euler's step in one component and in two, on one path and on several, and asks for scalar noise."""
    scheme, h = scheme_of(example(tmp_path), 20.0), 0.25
    for paths in (1, 5):
        state, noise = scheme.start(problem, paths, h), problem.drawn(np.random.default_rng(1), h, paths)
        found = scheme.step(problem, state, 0.0, h, noise).state
        wanted = state + h * problem.drift(0.0, state) + problem.diffused(0.0, state, noise.dW)
        np.testing.assert_allclose(found, wanted, rtol=1e-14)
    assert scheme.refuses(levy_area()) == "it needs a problem with scalar-noise"
