"""The commands and examples of the README and of the site are what is run and tested; so are its action and hooks."""

import importlib
import re
import shlex
import tomllib
from functools import cache
from pathlib import Path

import click
import pytest

from facade import load_registry, sdaeverify
from sdaeverify import __version__, sample, verify
from sdaeverify.testing import checks

ROOT = Path(__file__).parents[1]
README = (ROOT / "README.md").read_text()
PAGES = README + (ROOT / "docs" / "how-to" / "my-problem.md").read_text()


def example(name):
    return re.search(rf"<!-- example: {name} -->\n```\S+(?: \S+)?\n(.*?)```", PAGES, re.DOTALL).group(1)


def test_the_readme_is_two_screens():
    """What the site tells stands there, and not here."""
    assert len(README.splitlines()) <= 150


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


REPOSITORY = tomllib.loads((ROOT / "pyproject.toml").read_text())["project"]["urls"]["Repository"]
RAW = REPOSITORY.replace("github.com", "raw.githubusercontent.com")


def test_links_of_the_readme_lead_somewhere():
    """A link is whole, as an index of packages needs it, and names a file of the repository that is there."""
    links = re.findall(r"\]\(([^)]+)\)", README)
    files = [re.sub(rf"^(?:{re.escape(REPOSITORY)}/blob|{re.escape(RAW)})/main/", "", link) for link in links]

    assert [file for file in files if not (ROOT / file).is_file()] == []
    assert [link for link in links if "://" not in link] == []
    assert len(links) > 10


@pytest.mark.parametrize("page", ["README.md", "CITATION.cff", "pyproject.toml", "docs/install.md"])
def test_there_is_one_address(page):
    """Every address of the repository is the one of the package's metadata."""
    named = re.findall(r"https://(?:github|raw\.githubusercontent)\.com/[\w.-]+/[\w.-]+", (ROOT / page).read_text())

    assert {url.removesuffix(".git").rstrip("/.") for url in named} <= {REPOSITORY, RAW}
    assert named


def test_there_is_one_version():
    """Package, metadata and citation tell the same version, and the citation its date."""
    citation = (ROOT / "CITATION.cff").read_text()
    project = tomllib.loads((ROOT / "pyproject.toml").read_text())["project"]

    assert project["version"] == __version__
    assert re.search(r"^version: (.+)$", citation, re.MULTILINE).group(1) == __version__
    assert re.search(r"^date-released: \d{4}-\d\d-\d\d$", citation, re.MULTILINE)


PLACE = re.compile(r"`((?:sdaeverify|plugins|problems|tests|docs|reports)/[\w./-]+|\.ci/run)`")
TELLING = [
    ROOT / "README.md",
    ROOT / "CONTRIBUTING.md",
    *sorted((ROOT / "docs").glob("[eh]*/*.md")),
    ROOT / "docs/tutorial.md",
    ROOT / "docs/install.md",
]


@pytest.mark.parametrize("page", TELLING, ids=lambda page: page.stem)
def test_files_that_pages_name_are_there(page):
    """A page sends nobody to a file or folder that has moved; what a command writes is not committed."""
    written = {"reports/latest", "reports/gate", "docs/_site"}
    named = {place for place in PLACE.findall(page.read_text()) if not place.startswith(tuple(written))}

    assert sorted(place for place in named if not (ROOT / place).exists()) == []


CHOSEN = re.compile(r"(?<=\s)-[sp] ([\w,*\[\]=.-]+)")
INCLUDED = re.compile(r"\{literalinclude\} (\S+)")
SHELL = re.compile(r"```sh\n.*?```", re.DOTALL)


@cache
def registered():
    """Return the names of the shipped schemes and problems."""
    registry = load_registry(environ={})
    return {*registry.schemes, *registry.problems}


def names_of_nothing(page):
    """Return what the shell commands of a page select: neither registered, nor the name in a program on the page."""
    text = page.read_text()
    programs = [SHELL.sub("", text), *((page.parent / file).read_text() for file in INCLUDED.findall(text))]
    written = {name for program in programs for name in re.findall(r"[\w-]+", program)}
    chosen = {name for block in SHELL.findall(text) for names in CHOSEN.findall(block) for name in names.split(",")}
    plain = {name.partition("[")[0] for name in chosen if "*" not in name}
    return plain - registered() - written


@pytest.mark.parametrize("page", TELLING, ids=lambda page: page.stem)
def test_shell_commands_of_pages_select_names_that_there_are(page):
    """A reader who types them runs the scheme and the problem that the page is about."""
    assert names_of_nothing(page) == set()


def test_a_name_of_nothing_is_seen(tmp_path):
    """A command with another name than that of the program above it."""
    page = tmp_path / "page.md"
    page.write_text("`name wired`\n```sh\nsdaeverify matrix -s my-wired,wired -p gbm\n```\n")
    assert names_of_nothing(page) == {"my-wired"}


def commands():
    """Return what the action and the hooks run of this package: words after ``python -m sdaeverify``."""
    yaml = pytest.importorskip("yaml")
    action = yaml.safe_load((ROOT / "action.yml").read_text())
    hooks = yaml.safe_load((ROOT / ".pre-commit-hooks.yaml").read_text())
    scripts = [*(step.get("run", "") for step in action["runs"]["steps"]), *(hook["entry"] for hook in hooks)]
    return [
        re.sub(r"\$\{TIER:\+(.*?)\}", r"\1", found) for s in scripts for found in re.findall("sdaeverify (.*)", s)
    ]


def test_the_action_and_the_hooks_name_commands_that_there_are():
    """Each is a command with options that it has."""
    found = [words for words in map(str.split, commands()) if not words[0].endswith('"')]

    assert [words[0] for words in found] == ["gate", "gate", "check"]
    for name, *rest in found:
        known = {option for parameter in sdaeverify.get_command(None, name).params for option in parameter.opts}
        assert {word for word in rest if word.startswith("--")} <= known


def test_the_action_declares_what_it_uses():
    """Each input is used by a step, and each that is used is declared."""
    yaml = pytest.importorskip("yaml")
    text = (ROOT / "action.yml").read_text()

    assert set(re.findall(r"inputs\.([\w-]+)", text)) == set(yaml.safe_load(text)["inputs"])


def test_the_hook_of_the_page_is_the_one_of_the_repository():
    """The hook that a project copies from the page on CI runs what the repository's own does."""
    yaml = pytest.importorskip("yaml")
    page = (ROOT / "docs" / "how-to" / "ci.md").read_text()
    (written,) = (found for found in re.findall(r"```yaml\n(.*?)```", page, re.DOTALL) if "repo: local" in found)
    (copied,) = yaml.safe_load(written)["repos"][0]["hooks"]
    own = {hook["id"]: hook for hook in yaml.safe_load((ROOT / ".pre-commit-hooks.yaml").read_text())}

    assert copied.items() <= own[copied["id"]].items()


@pytest.mark.parametrize(
    "page", ["README.md", "CITATION.cff", "action.yml", *(f"docs/how-to/{p}.md" for p in ("ci", "bridge"))]
)
def test_no_address_is_left_to_be_filled_in(page):
    """What is copied from a page works as it is: no word in capitals stands for an owner."""
    assert "OWNER" not in (ROOT / page).read_text()


def test_no_measured_number_is_written_by_hand():
    """The page of measurements has numbers in what it includes, and in commands, alone."""
    page = (ROOT / "docs" / "explanation" / "measured.md").read_text()
    prose = re.sub(r"```.*?```|`[^`]*`|\{\{.*?\}\}|\]\(.*?\)", "", page, flags=re.DOTALL)

    assert re.findall(r".*(?<![A-Z])\d.*", prose) == []


def test_what_pages_quote_and_include_is_made(monkeypatch):
    """Each number that a page quotes, and each piece that it includes, is made of the code and of kept results."""
    monkeypatch.syspath_prepend(ROOT / "docs" / "_ext")
    made = {name: importlib.import_module(name) for name in ("counts", "findings", "kept", "reference")}
    reports, text = ROOT / "reports", "".join(page.read_text() for page in (ROOT / "docs").glob("[eh]*/*.md"))
    pages = made["kept"].kept_pages(reports) | made["findings"].finding_pages(reports / "reference")

    assert set(re.findall(r"\{\{ (\w+) \}\}", text)) <= set(made["counts"].counts(reports / "reference"))
    assert set(re.findall(r"generated/(pieces/[\w-]+\.md)", text)) == set(pages)
    assert [name for name, page in (pages | made["reference"].reference_pages()).items() if not page.strip()] == []


def test_each_command_has_an_example_that_parses(monkeypatch):
    """The reference shows an example of each command, with options that it has."""
    monkeypatch.syspath_prepend(ROOT / "docs" / "_ext")
    examples = importlib.import_module("reference").EXAMPLES
    context = click.Context(sdaeverify)

    assert set(sdaeverify.list_commands(context)) <= set(examples)
    for name in sdaeverify.list_commands(context):
        command, (first, *words) = sdaeverify.get_command(context, name), shlex.split(examples[name])
        assert first == name
        command.make_context(name, words, parent=context)


def test_each_mistake_has_a_repair(monkeypatch):
    """The page of each check of the kit says how to repair what it found."""
    monkeypatch.syspath_prepend(ROOT / "docs" / "_ext")
    repairs = importlib.import_module("repairs").REPAIRS

    for kind in ("scheme", "problem"):
        assert {check.name for check in checks(kind)} == set(repairs[kind])


# Formulas as docstrings write them, and as they are typeset.
TYPESET = {
    "dx = f(t, x) dt + B dW": r"\,dx = f(t, x) \,dt + B \,dW",
    "x+ = x + sqrt(h) sigma xi": r"x^{+} = x + \sqrt{h} \sigma  \xi",
    "(h/2) sum_j DB_j B_j": r"\tfrac{h}{2} \sum _{j} DB_{j} B_{j}",
    "r^ = M^{-1} grad g(r+) eta": r"\hat{r} = M^{-1} \nabla  g(r^{+}) \eta ",
}


@pytest.mark.parametrize(("plain", "tex"), TYPESET.items())
def test_a_formula_of_a_docstring_is_typeset(monkeypatch, plain, tex):
    """Symbols, roots, fractions and indices of plain text become TeX."""
    monkeypatch.syspath_prepend(ROOT / "docs" / "_ext")

    assert importlib.import_module("formulas").tex(plain).split() == tex.split()


def test_prose_of_a_docstring_stays_prose(monkeypatch):
    """Only formulas of a sentence are typeset: not its articles, its words and its code."""
    monkeypatch.syspath_prepend(ROOT / "docs" / "_ext")
    told = importlib.import_module("formulas").typeset(
        "A path keeps `x = 1` for h > 0, and the sum of a step.", lambda formula: f"<{formula}>", str
    )

    assert told == "A path keeps `x = 1` for <h > 0>, and the sum of a step."
