"""Directives of pages that are run: a file is written, a command is run, Python is run; what they print is shown.

A page has a folder of its own, in which all of it happens in order::

    ```{file} my_scheme.py            writes and shows a file; option :from: (a file of the repository)
    ```{command} list schemes         runs ``sdaeverify list schemes``; options :code: and :shown: (lines)
    ```{python}                       runs a program and shows it and what it prints; :picture: saves its figure
"""

import contextlib
import io
import shlex
import subprocess
import sys
import tempfile
from pathlib import Path
from typing import Any

from docutils import nodes
from docutils.parsers.rst import directives
from sphinx.application import Sphinx
from sphinx.util.docutils import SphinxDirective

PATIENCE = 900


class Running(SphinxDirective):
    """A directive with a folder for its page."""

    has_content = True

    @property
    def folder(self) -> Path:
        """The folder of the page: one for each page and build."""
        folders = self.env.temp_data.setdefault("sdaeverify_folders", {})
        if self.env.docname not in folders:
            folders[self.env.docname] = tempfile.TemporaryDirectory(prefix="page-")
        return Path(folders[self.env.docname].name)

    @property
    def text(self) -> str:
        """What is between the fences."""
        return "\n".join(self.content) + "\n"

    def block(self, text: str, language: str) -> nodes.Node:
        """Return a block of text."""
        block = nodes.literal_block(text.rstrip("\n"), text.rstrip("\n"))
        block["language"] = language
        return block


class File(Running):
    """Write a file and show it."""

    required_arguments = 1
    option_spec = {"hidden": directives.flag, "from": directives.path}

    @property
    def text(self) -> str:
        """What is between the fences, or in the file that is named."""
        if "from" not in self.options:
            return super().text
        source = Path(self.env.srcdir).parent / self.options["from"]
        self.env.note_dependency(str(source))
        return source.read_text(encoding="utf-8")

    def run(self) -> list[nodes.Node]:
        """Write the content."""
        path = self.folder / self.arguments[0]
        path.parent.mkdir(parents=True, exist_ok=True)
        path.write_text(self.text)
        if "hidden" in self.options:
            return []
        language = {".py": "python", ".toml": "toml", ".yml": "yaml", ".yaml": "yaml"}.get(path.suffix, "text")
        return [nodes.caption("", self.arguments[0]), self.block(self.text, language)]


class Command(Running):
    """Run ``sdaeverify`` and show the command and what it prints."""

    required_arguments = 1
    final_argument_whitespace = True
    option_spec = {
        "code": directives.nonnegative_int,
        "shown": directives.nonnegative_int,
        "in": directives.unchanged,
    }

    def run(self) -> list[nodes.Node]:
        """Run it; another exit code than expected ends the build."""
        command = [sys.executable, "-m", "sdaeverify", *shlex.split(self.arguments[0])]
        where = self.folder / self.options.get("in", ".")
        ended = subprocess.run(command, cwd=where, capture_output=True, text=True, timeout=PATIENCE, check=False)
        expected = self.options.get("code", 0)
        if ended.returncode != expected:
            told = (
                f"{self.arguments[0]!r} exits with {ended.returncode}, not {expected}:\n{ended.stdout}{ended.stderr}"
            )
            raise self.error(told)
        told = (ended.stdout + ended.stderr).replace(str(self.folder), ".").rstrip().splitlines()
        shown = self.options.get("shown", len(told))
        rest = ["..."] if shown < len(told) else []
        return [self.block("\n".join([f"$ sdaeverify {self.arguments[0]}", "", *told[:shown], *rest]), "text")]


class Python(Running):
    """Run Python and show it with what it prints."""

    option_spec = {"picture": directives.unchanged}

    def run(self) -> list[nodes.Node]:
        """Run it in the page's folder, in the names that its page has so far."""
        names = self.env.temp_data.setdefault("sdaeverify_names", {"__name__": "__page__"})
        printed = io.StringIO()
        with contextlib.chdir(self.folder), contextlib.redirect_stdout(printed):
            exec(compile(self.text, self.env.docname, "exec"), names)
        found: list[nodes.Node] = [self.block(self.text, "python")]
        if printed.getvalue():
            found.append(self.block(printed.getvalue(), "text"))
        if "picture" in self.options:
            found.append(self._picture(self.options["picture"]))
        return found

    def _picture(self, name: str) -> nodes.Node:
        from matplotlib import pyplot as plt  # noqa: PLC0415 - only pictures need it

        folder = Path(self.env.srcdir) / "generated" / "pictures"
        folder.mkdir(parents=True, exist_ok=True)
        plt.gcf().savefig(folder / name)
        plt.close("all")
        return nodes.image(uri=f"/generated/pictures/{name}", alt=name)


def setup(app: Sphinx) -> dict[str, Any]:
    """Add the directives."""
    for name, directive in {"file": File, "command": Command, "python": Python}.items():
        app.add_directive(name, directive)
    return {"parallel_read_safe": True}
