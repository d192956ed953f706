"""What the build asks of the site at its end: every link leads somewhere, every doctest holds."""

import doctest
from html.parser import HTMLParser
from importlib import import_module
from pathlib import Path
from pkgutil import walk_packages
from typing import Any
from urllib.parse import unquote, urlsplit

from sphinx.application import Sphinx
from sphinx.errors import ExtensionError

import sdaeverify


class Page(HTMLParser):
    """The links and the anchors of a page."""

    def __init__(self, text: str) -> None:
        super().__init__()
        self.links: set[str] = set()
        self.anchors: set[str] = set()
        self.feed(text)

    def handle_starttag(self, tag: str, attrs: list[tuple[str, str | None]]) -> None:
        """Note where it leads and what it names."""
        given = dict(attrs)
        self.anchors |= {value for name in ("id", "name") if (value := given.get(name))}
        self.links |= {value for name in ("href", "src") if (value := given.get(name))}


def broken_links(site: Path) -> list[str]:
    """Return the links within a site that lead nowhere."""
    files = (path for path in sorted(site.rglob("*.html")) if "_static" not in path.parts)
    pages = {path: Page(path.read_text(encoding="utf-8")) for path in files}
    return [
        f"{path.relative_to(site)}: {link}"
        for path, page in pages.items()
        for link in sorted(page.links)
        if not _leads_somewhere(path, link, pages)
    ]


def _leads_somewhere(path: Path, link: str, pages: dict[Path, Page]) -> bool:
    parts = urlsplit(link)
    if parts.scheme or parts.netloc or (link.startswith(("#", "data:")) and parts.fragment in {"", "top"}):
        return True
    target = (path.parent / unquote(parts.path)).resolve() if parts.path else path
    target = target / "index.html" if target.is_dir() else target
    if target not in pages:
        return target.exists()
    return not parts.fragment or unquote(parts.fragment) in pages[target].anchors


def failed_doctests(folder: Path) -> list[str]:
    """Return the pages and modules in which an example of a session does not print what it shows."""
    pages = [path for path in folder.rglob("*.md") if ">>> " in path.read_text(encoding="utf-8")]
    failed = [str(path) for path in pages if doctest.testfile(str(path), module_relative=False).failed]
    modules = (
        found.name for found in walk_packages(sdaeverify.__path__, "sdaeverify.") if "__main__" not in found.name
    )
    return failed + [name for name in modules if doctest.testmod(import_module(name)).failed]


def _check(app: Sphinx, failure: Exception | None) -> None:
    if failure is None and app.builder.format == "html":
        wrong = [*broken_links(Path(app.outdir)), *failed_doctests(Path(app.srcdir))]
        if wrong:
            raise ExtensionError("links that lead nowhere, or doctests that fail:\n" + "\n".join(wrong))


def setup(app: Sphinx) -> dict[str, Any]:
    """Check at the end of the build."""
    app.connect("build-finished", _check, priority=900)
    return {"parallel_read_safe": True}
