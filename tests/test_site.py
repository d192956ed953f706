"""The built site in a browser: pages without complaints, and a search that finds what users look for."""

import threading
from functools import partial
from http.server import SimpleHTTPRequestHandler, ThreadingHTTPServer
from pathlib import Path

import pytest

from browser import browser, needs_chromium
from facade import load_registry
from sdaeverify.testing import checks

SITE = Path(__file__).parents[1] / "docs" / "_site"
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
    "generated/forms",
    "how-to/cluster",
    "generated/api/sdaeverify",
)
# What is looked for, and a page that has to be among what is found.
SOUGHT = {
    "refuses": "how-to/my-scheme",
    "traits": "generated/traits",
    "exit code 4": "generated/exit-codes",
    "drift-truncated": "generated/schemes/drift-truncated-euler",
}
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
