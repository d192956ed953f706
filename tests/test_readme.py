"""The README's commands and examples are what is run and tested."""

import re
from pathlib import Path

import pytest

from sdaeverify import sample, verify

ROOT = Path(__file__).parents[1]
README = (ROOT / "README.md").read_text()


def example(name):
    return re.search(rf"<!-- example: {name} -->\n```python\n(.*?)```", README, re.DOTALL).group(1)


@pytest.mark.parametrize("name", ["scheme", "problem", "fibre"])
def test_examples_are_short(name):
    """A scheme and a problem take fewer than 30 lines."""
    assert len(example(name).splitlines()) < 30


@pytest.mark.quick
def test_examples_work_as_plugin_files(tmp_path):
    """Both examples load by path, and the scheme keeps its promise on the problem."""
    files = []
    for name in ("scheme", "problem"):
        files.append(tmp_path / f"{name}.py")
        files[-1].write_text(example(name))

    verdicts = verify("predictor-corrector", "stochastic-exponential", "strong", plugins=files).verdicts

    assert set(verdicts.verdict) == {"verified"}


def test_a_fibre_of_ones_own(tmp_path):
    """The example of a fibre loads by path, and a scheme moves it."""
    file = tmp_path / "fibre.py"
    file.write_text(example("fibre"))

    paths = sample("semi-implicit-projection-euler", "fibre-in-shear", steps=16, paths=2, plugins=[file])

    assert paths["r"].shape == (17, 14, 2)
    assert not paths.without_root.any()
    assert not paths.lost.any()
    # Straight down at first, and drawn aside by the flow, which is negative below the clamp.
    assert paths["r"][0, -2, 0] == 0.0
    assert paths["r"][-1, -2].max() < 0.0


def test_ci_uses_the_command_of_the_readme():
    """What CI runs as tests is what the README tells a newcomer to run."""
    command = re.search(r"## Test it\n\n```sh\n(.*?)\n```", README, re.DOTALL).group(1)

    quiet = (ROOT / ".ci" / "run").read_text().replace(" --quiet", "")

    assert command in quiet
