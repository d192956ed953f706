"""The README's commands and examples are what is run and tested."""

import re
from pathlib import Path

import pytest

from sdaeverify import verify

ROOT = Path(__file__).parents[1]
README = (ROOT / "README.md").read_text()


def example(name):
    return re.search(rf"<!-- example: {name} -->\n```python\n(.*?)```", README, re.DOTALL).group(1)


@pytest.mark.parametrize("name", ["scheme", "problem"])
def test_examples_are_short(name):
    """A scheme and a problem take fewer than 30 lines."""
    assert len(example(name).splitlines()) < 30


def test_examples_work_as_plugin_files(tmp_path):
    """Both examples load by path, and the scheme keeps its promise on the problem."""
    files = []
    for name in ("scheme", "problem"):
        files.append(tmp_path / f"{name}.py")
        files[-1].write_text(example(name))

    verdicts = verify("predictor-corrector", "stochastic-exponential", "strong", plugins=files).verdicts

    assert set(verdicts.verdict) == {"verified"}


def test_ci_uses_the_command_of_the_readme():
    """What CI runs as tests is what the README tells a newcomer to run."""
    command = re.search(r"## Test it\n\n```sh\n(.*?)\n```", README, re.DOTALL).group(1)

    quiet = (ROOT / ".ci" / "run").read_text().replace(" --quiet", "")

    assert command in quiet
