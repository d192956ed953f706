"""The built site in a browser: pages without complaints, and a search that finds what users look for."""

import re
import threading
from functools import partial
from http.server import SimpleHTTPRequestHandler, ThreadingHTTPServer
from pathlib import Path

import pytest

from browser import browser, needs_chromium
from facade import load_registry
from sdaeverify.testing import checks

SITE = Path(__file__).parents[1] / "docs" / "_site"
pytestmark = pytest.mark.long
BUILT = pytest.mark.skipif(not (SITE / "index.html").exists(), reason="first: python -m sphinx -W docs docs/_site")
PAGES = (
    "index",
    "tutorial",
    "how-to/decisions",
    "how-to/ci",
    "explanation/verdicts",
    "gallery_pages/index",
    "gallery_pages/plot_kubo",
    "generated/exit-codes",
    "generated/mistakes",
    "generated/schemes/half-explicit-euler",
    "generated/problems/pendulum",
    "how-to/cluster",
    "generated/api/sdaeverify",
    "generated/api/sdaeverify.Result",
    "explanation/quantities",
    "install",
    "reference/glossary",
)
# What is looked for, and a page that has to be among what is found.
SOUGHT = {
    "refuses": "how-to/my-scheme",
    "traits": "generated/traits",
    "exit code 4": "generated/exit-codes",
    "drift-truncated": "generated/schemes/drift-truncated-euler",
    "Result.verdicts": "generated/api/sdaeverify.Result",
}
# What is looked for, and the page that has to be found first.
FIRST = {
    "order": "reference/glossary",
    "stability": "reference/glossary",
    "multiplier": "reference/glossary",
    "AttributeError": "how-to/faq",
    "tier": "reference/glossary",
}
# Pixels of the content of a page, at a width of 1280.
HIGHEST = 6000
NARROW = 390
# Folders of which each page is looked at on a narrow screen.
ROOMS = (
    ".",
    "how-to",
    "explanation",
    "reference",
    "gallery_pages",
    "generated",
    "generated/schemes",
    "generated/problems",
    "generated/mistakes",
)
FOUND = "[...document.querySelectorAll('#search-results ul.search li a')].map(a => a.getAttribute('href'))"
FINISHED = """new Promise(done => {
  const summary = () => document.querySelector('.search-summary')?.textContent ?? '';
  const wait = () => summary().match(/found/) ? done() : setTimeout(wait, 50);
  wait();
})"""


class Quiet(SimpleHTTPRequestHandler):
    def log_message(self, *words):
        pass


@pytest.fixture(scope="module")
def address():
    """Serve the site on this machine alone, as a server does for its users."""
    with ThreadingHTTPServer(("127.0.0.1", 0), partial(Quiet, directory=SITE)) as server:
        threading.Thread(target=server.serve_forever, daemon=True).start()
        yield f"http://127.0.0.1:{server.server_address[1]}"
        server.shutdown()


@pytest.fixture(scope="module")
def window():
    with browser() as page:
        page.ask(
            "Network.emulateNetworkConditions", offline=False, latency=0, downloadThroughput=-1, uploadThroughput=-1
        )
        yield page


@BUILT
def test_everything_that_is_registered_has_a_page():
    """Schemes, problems and the kit's checks are told, each on a page of its own."""
    registry = load_registry(environ={})
    names = [f"schemes/{name}" for name in registry.schemes] + [f"problems/{name}" for name in registry.problems]
    names += [f"mistakes/{kind}-{check.name}" for kind in ("scheme", "problem") for check in checks(kind)]

    assert [name for name in names if not (SITE / "generated" / f"{name}.html").exists()] == []


@BUILT
def test_the_site_is_small():
    """All that is published, without the caches of the build, has less than 30 MB."""
    files = [path for path in SITE.rglob("*") if path.is_file() and ".doctrees" not in path.parts]
    assert sum(path.stat().st_size for path in files) < 30_000_000


@BUILT
@needs_chromium
@pytest.mark.parametrize("name", PAGES)
def test_a_page_is_shown_without_complaints(address, window, name):
    """A page writes nothing to the console, and asks nobody but its own server."""
    window.visit(f"{address}/{name}.html")

    assert window.run("document.querySelector('h1').textContent.length") > 1
    assert window.complaints == []
    assert [url for url in window.requests if not url.startswith(address)] == []


@BUILT
@needs_chromium
@pytest.mark.parametrize(("sought", "page"), SOUGHT.items())
def test_search_finds(address, window, sought, page):
    """The search of the site finds the page."""
    window.visit(f"{address}/search.html?q={sought.replace(' ', '+')}")
    window.run(FINISHED)

    assert any(page in link for link in window.run(FOUND)), window.run(FOUND)


@BUILT
@needs_chromium
@pytest.mark.parametrize(("sought", "page"), FIRST.items())
def test_search_finds_first(address, window, sought, page):
    """The page that explains a word is the first that is found."""
    window.visit(f"{address}/search.html?q={sought}")
    window.run(FINISHED)

    assert page in window.run(FOUND)[0], window.run(FOUND)[:5]


@BUILT
@needs_chromium
def test_pages_of_names_are_short(address, window):
    """The longest pages of public names are a few screens."""
    window.ask("Emulation.setDeviceMetricsOverride", width=1280, height=900, deviceScaleFactor=1, mobile=False)
    heights = {}
    pages = sorted((SITE / "generated" / "api").glob("*.html"), key=lambda path: path.stat().st_size)
    for path in pages[-20:]:
        window.visit(f"{address}/generated/api/{path.name}")
        heights[path.stem] = window.run("document.querySelector('article').scrollHeight")

    assert {name: height for name, height in heights.items() if height > HIGHEST} == {}
    assert len(pages) > 200


@BUILT
@needs_chromium
@pytest.mark.parametrize("name", ROOMS)
def test_pages_fit_a_telephone(address, window, name):
    """No page is wider than a narrow screen, what is wide is scrolled by itself; no picture is missing."""
    window.ask("Emulation.setDeviceMetricsOverride", width=NARROW, height=844, deviceScaleFactor=1, mobile=True)
    widths, missing, pages = {}, {}, sorted((SITE / name).glob("*.html"))
    for path in pages:
        window.visit(f"{address}/{path.relative_to(SITE).as_posix()}")
        widths[path.stem] = window.run("document.documentElement.scrollWidth")
        missing[path.stem] = window.run("[...document.images].filter(i => i.complete && !i.naturalWidth).length")

    assert pages
    assert {page: width for page, width in widths.items() if width > NARROW} == {}
    assert {page: count for page, count in missing.items() if count} == {}


@BUILT
def test_formulas_are_typeset_without_a_script():
    """Formulas are MathML, no page asks for a script of another place, and none shows the source of a formula."""
    pages = {path: path.read_text() for path in SITE.rglob("*.html") if "_static" not in path.parts}
    shown = {
        path: re.sub(r"<pre>.*?</pre>|<annotation.*?</annotation>", "", text, flags=re.DOTALL)
        for path, text in pages.items()
    }

    assert sum("<math " in text for text in pages.values()) > 100
    assert [path for path, text in pages.items() if re.search(r'<script[^>]+src="https?:', text)] == []
    assert [path.name for path, text in shown.items() if ":math:" in text or "\\begin{" in text] == []
