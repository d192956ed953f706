"""The page of a run in a browser without network: the numbers of the tables, and texts of plugins as texts."""

import json
import math
import re
from functools import cache
from html import unescape
from importlib.resources import files
from pathlib import Path

import pytest

from browser import browser, needs_chromium
from facade import read_tables
from report.rows import level, tables, verdict, weak
from sdaeverify import UsageError
from sdaeverify.report.html import PAGE, page_text, payload, remove_page, write_page

REFERENCE = Path(__file__).resolve().parents[2] / "reports" / "reference"
HOSTILE = "</script><script>alert(1)</script><img src=x onerror=alert(2)>\u2028'\"&amp;%%data%%"
FITS = "document.documentElement.scrollWidth <= document.documentElement.clientWidth"
MARKS = """[...document.querySelectorAll('circle.dot')].map(c => [+c.dataset.h, +c.dataset.e,
  +c.getAttribute('cx'), +c.getAttribute('cy'), c.classList.contains('hollow')])"""
HATCHED = "getComputedStyle(document.querySelector('.cell.inconclusive')).backgroundImage"
BOUND = "needs constraint_bound"
MEGABYTE = 1_000_000
SIZES = [0.125, 0.0625, 0.03125]
ERRORS = [0.0401, 0.0203, 0.0102]


def run():
    """Return a run of two schemes on one problem, one of them undecided."""
    levels = [
        level(h=str(h), estimate=str(e), std_error=str(e / 20), fitted=str(h < 0.1), steps=str(int(1 / h)))
        for h, e in zip(SIZES, ERRORS, strict=True)
    ]
    other = verdict(scheme="other-scheme", verdict="inconclusive", reason="too few paths; about 9000 would decide")
    absent = verdict(scheme="other-scheme", problem="circle", reason="needs constraint_bound")
    return tables([verdict(), weak(), other, verdict(problem="circle")], levels, absent=[absent])


def hostile():
    """Return a run in which every text that a plugin can choose is an attack."""
    chosen = ("scheme", "problem", "quantity", "reason", "claim_source", "method", "view", "class")
    texts = dict.fromkeys(chosen, HOSTILE)
    passport = {"label": HOSTILE, "text": HOSTILE, "form": HOSTILE, "source": HOSTILE, "truths": [HOSTILE]}
    passports = {"schemes": {HOSTILE: passport}, "problems": {HOSTILE: passport}, "measures": {"strong": passport}}
    names = dict.fromkeys(("scheme", "problem", "quantity"), HOSTILE)
    return payload(tables([verdict(**texts)], [level(**names), level(**names, h="0.5", estimate="0.04")]), passports)


@cache
def reference():
    """Return the page of the committed reference run."""
    return page_text(payload(read_tables(REFERENCE)))


def test_numbers_reach_the_page_with_six_digits_and_texts_once():
    """The page holds what the tables hold."""
    data = payload(run())
    assert data["findings"]["scheme"] == {"words": ["some-euler", "other-scheme"], "at": [0, 0, 1, 0]}
    assert data["levels"][0]["estimate"] == ERRORS
    assert data["levels"][0]["fitted"] == [0, 1, 1]
    assert data["findings"]["path_order"] == [0.392, None, 0.392, 0.392]
    assert data["sentence"].startswith("4 quantities: 2 verified, none refuted, 1 inconclusive, 1 without a claim")
    json.dumps(data, allow_nan=False)


def test_the_page_is_one_file_of_its_own():
    """Nothing in it refers to another file, and its policy lets nothing be fetched."""
    text = page_text(payload(run()))
    for nothing in ("default-src 'none'", "base-uri 'none'", "form-action 'none'"):
        assert (
            f"{nothing};"
            in f"{unescape(text).partition('Content-Security-Policy')[2].partition('>')[0]};".replace('";', ";")
        )
    assert not re.search(r"(src|href)\s*=\s*[\"']?(https?:|//)", text)
    assert not re.search(r"@import|url\(", text)


@pytest.mark.long
def test_the_page_of_the_reference_run_is_small():
    """The default matrix fits into four megabytes."""
    assert len(reference().encode()) < 4 * MEGABYTE


def test_a_text_of_a_plugin_cannot_leave_its_place():
    """Neither the data nor the frame holds markup of a plugin."""
    text = page_text(hostile())
    assert text.count("<script") == 2
    assert "<img" not in text


def test_a_folder_without_a_run_is_told_in_one_line(tmp_path):
    """There is no page of nothing."""
    with pytest.raises(UsageError, match=r"holds no run: cannot read verdicts\.csv"):
        write_page(tmp_path)


def test_a_page_of_an_earlier_run_is_removed(tmp_path):
    """A page that is not written again would show numbers that the tables no longer hold."""
    (tmp_path / PAGE).write_text("old")
    remove_page(tmp_path)
    remove_page(tmp_path)
    assert not (tmp_path / PAGE).exists()


@pytest.fixture(scope="module")
def chromium():
    """Give a browser without network."""
    with browser() as opened:
        yield opened


@pytest.fixture
def shown(chromium, tmp_path):
    """Show the page of a run."""

    def show(text, fragment=""):
        (tmp_path / PAGE).write_text(text, encoding="utf-8")
        chromium.look()
        chromium.open(tmp_path / PAGE, fragment)
        return chromium

    return show


def complaints_of(page):
    """Return what is wrong with a page."""
    return [*page.complaints, *page.requests]


@pytest.mark.long
@needs_chromium
def test_every_page_of_the_reference_run_is_drawn_without_complaint(shown):
    """At two widths, light, dark and printed there is no console error, no request, nothing wider than the window."""
    page = shown(reference())
    targets = page.run("[...document.querySelectorAll('nav a')].map(a => a.hash)")
    targets += ["#/cell/half-explicit-euler/pendulum", "#/scheme/half-explicit-euler", "#/problem/pendulum"]
    for target in targets:
        page.go(f"{target}?0")
        page.go(target)
        assert page.run("document.querySelector('main').innerText.length") > 100, target
        for width, scheme, media in ((1280, "light", ""), (400, "dark", ""), (1047, "light", "print")):
            page.look(width, scheme=scheme, media=media)
            assert page.run(FITS), (target, width)
    assert not complaints_of(page)


@pytest.mark.long
@needs_chromium
def test_the_first_picture_of_the_reference_run_is_there_within_two_seconds(shown):
    """From the request of the file to the first paint, the quickest of three where others keep the machine busy."""

    def milliseconds():
        page = shown(reference())
        page.run("new Promise(done => requestAnimationFrame(() => requestAnimationFrame(done)))")
        paints = page.run("performance.getEntriesByType('paint').map(one => one.startTime)")
        return max(paints) if paints else page.run("performance.now()")

    assert any(milliseconds() < 2000 for _ in range(3))


@needs_chromium
def test_blocks_of_a_narrow_screen_name_their_cells(shown):
    """Where a row of reasons becomes a block, each of its lines begins with the heading of its column."""
    page = shown(page_text(payload(run())))
    told = """[...document.querySelectorAll('table.reasons tbody tr:first-child td:not(:empty)')]
        .map(cell => getComputedStyle(cell, '::before').content)"""
    page.look(1280)
    assert {*page.run(told)} == {"none"}
    page.look(400)
    labels = [label.strip('"').replace('" "', "") for label in page.run(told)]
    assert labels[1:4] == ["scheme: ", "problem: ", "quantity: "]
    page.look()


def luminance(colour):
    """Return the relative luminance of a colour such as #1b1f24, as WCAG 2.2 defines it."""
    digits = colour.removeprefix("#")
    digits = digits if len(digits) == 6 else "".join(2 * digit for digit in digits)
    parts = [int(digits[at : at + 2], 16) / 255 for at in (0, 2, 4)]
    linear = [part / 12.92 if part <= 0.04045 else ((part + 0.055) / 1.055) ** 2.4 for part in parts]
    return sum(weight * part for weight, part in zip((0.2126, 0.7152, 0.0722), linear, strict=True))


def test_text_can_be_read_in_light_dark_and_print():
    """Each colour of a text has a contrast of 4.5 with what is behind it (WCAG 2.2, 1.4.3, level AA)."""
    style = files("sdaeverify.report.html").joinpath("page.css").read_text(encoding="utf-8")
    themes = re.findall(r":root \{(.*?)\}", style, re.DOTALL)
    behind = {name: (f"{name}-bg",) for name in ("verified", "refuted", "open", "failed")}
    behind |= {"none": ("paper", "none-bg"), **dict.fromkeys(("ink", "soft", "accent"), ("paper", "panel"))}
    assert len(themes) == 3
    for theme in themes:
        light = {name: luminance(colour) + 0.05 for name, colour in re.findall(r"--([\w-]+): (#\w+)", theme)}
        pairs = [(light[name], light[back]) for name, backs in behind.items() for back in backs]
        assert min(max(pair) / min(pair) for pair in pairs) >= 4.5


@needs_chromium
def test_measures_that_fail_alike_are_one_row(shown):
    """A step that raises is one row of the summary for each problem; lists of names have a column for errors."""
    measures = ("drift", "effort", "limits", "moments", "stability", "strong", "weak", "uniform")
    same = {"verdict": "error", "claim": "", "claimed_order": "", "quantity": "", "reason": "AttributeError: drfit"}
    page = shown(page_text(payload(tables([verdict(), *(verdict(measure=name, **same) for name in measures)]))))
    (told,) = page.run("[...document.querySelectorAll('table.reasons tbody tr')].map(row => row.cells[3].innerText)")
    assert told == "drift, effort, limits, moments and 4 more"
    counts = page.run("[...document.querySelectorAll('table.tight tbody td')].map(cell => cell.innerText)")
    assert (counts.count("! 1"), counts.count("○ 1")) == (len(measures) - 1, 0)
    page.go("#/schemes")
    assert page.run("[...document.querySelectorAll('th')].at(-1).innerText") == "in error"
    assert page.run("[...document.querySelectorAll('tbody td')].at(-1).innerText") == "8"


@needs_chromium
def test_labels_of_axes_do_not_cover_those_of_ticks(shown):
    """The name of the vertical axis stands left of its numbers, also of small ones with powers of ten."""
    small = [
        level(h=str(h), estimate=str(e * 1e-16), std_error="0", steps=str(int(1 / h)))
        for h, e in zip(SIZES, ERRORS, strict=True)
    ]
    page = shown(page_text(payload(tables([verdict()], small))), "#/cell/some-euler/gbm")
    apart = """(() => { const texts = [...document.querySelectorAll('article svg text')];
        const name = texts.find(text => text.textContent === 'error').getBoundingClientRect();
        return Math.min(...texts.filter(text => text.getAttribute('text-anchor') === 'end')
            .map(text => text.getBoundingClientRect().left)) - name.right; })()"""
    assert page.run(apart) >= 0


@needs_chromium
def test_a_run_of_classes_alone_has_a_page(shown):
    """Its first page has the verdicts on classes, scheme by scheme, as the page of a scheme has them."""
    known = read_tables(REFERENCE)
    page = shown(page_text(payload(known._replace(verdicts=[], absent=[], levels=[], details=[]))))
    assert page.run("document.querySelector('h1').innerText") == "Classes of equations"
    assert page.run("document.querySelector('nav a[aria-current]').innerText") == "Classes"
    headings = page.run("[...document.querySelectorAll('h2')].map(each => each.innerText)")
    assert headings == [*dict.fromkeys(row["scheme"] for row in known.classes)]
    page.look(400)
    label = page.run("getComputedStyle(document.querySelector('table.blocks td'), '::before').content")
    assert label.replace('" "', "") == '"class: "'
    assert page.run(FITS)
    page.look()
    assert page.run(FITS)
    assert not complaints_of(page)


NOWHERE = [
    *("#/nowhere", "#/cell/no-scheme/pendulum", "#/cell/half-explicit-euler", "#/scheme/no-scheme", "#/problem/"),
    *("#/table/99", "#/history", "#/constructor", "#/__proto__/x", "#/summary/more", "#/%E0%A4%A"),
]


@pytest.mark.long
@needs_chromium
def test_an_unknown_address_leads_to_the_summary(shown):
    """Opened there, or sent there later, the page shows its first part, and nothing is wrong."""
    page = shown(reference(), NOWHERE[0])
    titles = [page.run("document.title")]
    for address in NOWHERE:
        page.go("#/matrix")
        page.go(address)
        titles.append(page.run("document.title"))
        assert page.run("document.querySelector('nav a[aria-current]').innerText") == "Summary"

    assert {*titles} == {"Summary \u00b7 sdaeverify"}
    assert not complaints_of(page)


EQUATION = "some-euler, {}: weak order 1; a step solves\\n    drift       f + h (-1/2 f' f)"
OF_CLASS = {"scheme": "some-euler", "measure": "weak", "verdict": "verified", "claimed_order": "1", "motions": "1"}


@needs_chromium
def test_modified_equations_are_on_the_page_of_a_scheme(shown):
    """Classes with the same terms share a card, which draws a tree for each term; without equations there is none."""
    rows = [
        {**OF_CLASS, "class": kind, "modified": EQUATION.format(kind), "modified_terms": "f(f): -1/2 f' f"}
        for kind in ("ode", "additive")
    ]
    page = shown(page_text(payload(run()._replace(classes=rows))), "#/scheme/some-euler")
    cards = page.run("[...document.querySelectorAll('.equations .card')].map(one => one.innerText)")

    assert len(cards) == 1
    assert cards[0].startswith("ode, additive: weak order 1; a step solves")
    assert "f + h (-1/2 f' f)" in cards[0]
    assert page.run("document.querySelectorAll('.equations figure circle').length") == 2
    assert page.run("document.querySelector('.equations figcaption').textContent") == "-1/2 f' f"
    assert not complaints_of(page)
    page.go("#/scheme/other-scheme")
    assert page.run("document.querySelectorAll('.equations').length") == 0


@needs_chromium
def test_pictures_show_the_numbers_of_the_tables(shown):
    """Points stand where their numbers are on logarithmic axes; levels that are not fitted are hollow."""
    page = shown(page_text(payload(run())), "#/cell/some-euler/gbm")
    marks = page.run(MARKS)
    assert [(h, e) for h, e, *_ in marks] == list(zip(SIZES, ERRORS, strict=True))
    assert [hollow for *_, hollow in marks] == [True, False, False]
    for place, of in ((2, 0), (3, 1)):
        pixels, logs = [mark[place] for mark in marks], [math.log(mark[of]) for mark in marks]
        slope = (pixels[2] - pixels[0]) / (logs[2] - logs[0])
        assert pixels[1] == pytest.approx(pixels[0] + slope * (logs[1] - logs[0]), abs=0.01)
    slopes = page.run("[...document.querySelectorAll('[data-slope]')].map(one => +one.dataset.slope)")
    assert sorted(slopes) == [0.3, 0.392, 0.5]
    text = page.run("document.querySelector('main').innerText")
    claim = "order ≥ 0.5 (sampled: ≥ 0.3)"
    for told in (claim, "local order (T1)", "paths, exact solution", "0.39 [0.36, 0.43]"):
        assert told in text
    assert "a mean difference is 0.2 standard errors" in text
    assert "14.05" not in text


@needs_chromium
@pytest.mark.parametrize("known", [0, 1])
def test_radii_that_are_not_known_are_not_drawn(shown, known):
    """A point for each radius that is a number, and a sentence in place of a picture where none is."""
    radii = [("0.5", "nan"), ("0.25", "0.9")][: 1 + known]
    levels = [level(measure="stability", quantity="E", h=h, estimate=radius) for h, radius in radii]
    data = payload(tables([verdict(measure="stability", quantity="E")], levels))

    page = shown(page_text(data), "#/cell/some-euler/gbm")

    assert len(page.run(MARKS)) == known
    told = page.run("document.querySelector('main').innerText")
    assert ("no spectral radius is known" in told) == (known == 0)
    assert not complaints_of(page)


@needs_chromium
def test_densities_and_work_are_those_of_the_tables(shown):
    """Both densities of a coordinate, solid and dashed, with half the area between them; errors against seconds."""
    at, own, exact = [-1.0, 0.0, 1.0], [0.1, 0.6, 0.2], [0.2, 0.5, 0.3]
    about = {"measure": "invariant", "quantity": "density of coordinate 1", "steps": "", "h": "0.25"}
    rows = [level(**about, at=str(x), estimate=str(a), exact=str(b)) for x, a, b in zip(at, own, exact, strict=True)]
    found = run()
    verdicts = [*found.verdicts, verdict(measure="invariant", quantity="x^2", path_order="")]
    details = [{**row, "step_seconds": "0.002"} for row in found.details]
    data = payload(found._replace(verdicts=verdicts, levels=[*found.levels, *rows], details=details))
    page = shown(page_text(data), "#/cell/some-euler/gbm")
    card = "[...document.querySelectorAll('.card')].find(c => c.querySelector('path.exact'))"
    assert page.run(f"{card}.querySelectorAll('path.line').length") == 1
    cells = page.run(f"[...{card}.querySelectorAll('tbody td')].map(c => c.textContent.replace('\u2212', '-'))")
    assert [float(cell) for cell in cells] == [x for row in zip(at, own, exact, strict=True) for x in row]
    assert "at h = 0.25" in page.run(f"{card}.textContent")
    assert "the gap is 0.1 of the probability" in page.run(f"{card}.textContent")
    assert page.run(f"getComputedStyle({card}.querySelector('path.exact')).strokeDasharray") == "6px, 4px"
    page.go("#/problem/gbm")
    work = """[...document.querySelector('[aria-label^="work and precision"]').querySelectorAll('circle')]
      .map(c => [+c.dataset.h, +c.dataset.e])"""
    assert page.run(work) == [[pytest.approx(0.002 / h), e] for h, e in zip(SIZES, ERRORS, strict=True)]
    for target in ("#/cell/some-euler/gbm", "#/problem/gbm", "#/invariant"):
        page.go(f"{target}?0")
        page.go(target)
        for width, scheme, media in ((1280, "light", ""), (400, "dark", ""), (1047, "light", "print")):
            page.look(width, scheme=scheme, media=media)
            assert page.run(FITS), (target, width)
    assert not complaints_of(page)


@needs_chromium
def test_the_first_page_says_how_the_error_level_is_shared(shown):
    """The number of tests and of looks are those of the run's settings."""
    page = shown(page_text(payload(run())))
    assert "error level shared among 1000 tests and 6 looks" in page.run("document.body.textContent")


@needs_chromium
def test_cells_are_opened_by_keyboard_and_empty_ones_say_why(shown):
    """Arrow keys move, Enter opens; what does not apply names its reason."""
    page = shown(page_text(payload(run())), "#/matrix")
    page.run("document.querySelector('.cell[tabindex=\"0\"]').focus()")
    page.press("ArrowDown")
    label = page.run("document.activeElement.getAttribute('aria-label')")
    page.press("Enter")
    assert label == "some-euler on circle: 1 verified"
    assert page.run("location.hash") == "#/cell/some-euler/circle"
    page.go("#/cell/other-scheme/circle")
    assert BOUND in page.run("document.querySelector('main').innerText")


@needs_chromium
def test_filters_leave_what_fits(shown):
    """A link from the summary shows what is undecided; a measure that nothing has leaves nothing."""
    page = shown(page_text(payload(run())), "#/matrix?verdict=inconclusive")
    assert page.run("[...document.querySelectorAll('tbody .cell')].map(one => one.textContent)") == ["?1"]
    assert "repeating-linear-gradient" in page.run(HATCHED)


@needs_chromium
def test_pictures_and_places_have_names_for_those_who_do_not_see(shown):
    """Each picture is an image with a label, and the page has its landmarks."""
    page = shown(page_text(payload(run())), "#/cell/some-euler/gbm")
    tree = page.ask("Accessibility.getFullAXTree")["nodes"]
    roles = {(node["role"]["value"], node.get("name", {}).get("value", "")) for node in tree if not node["ignored"]}
    assert ("image", "strong x of some-euler on gbm") in roles
    assert ("navigation", "Pages") in roles
    assert any(role == "main" for role, _ in roles)


@pytest.mark.long
@needs_chromium
def test_hostile_names_are_shown_as_they_are(shown):
    """No page runs or draws what a name says."""
    page = shown(page_text(hostile()))
    for link in page.run("[...document.querySelectorAll('a')].map(a => a.hash)"):
        page.run(f"location.hash = {json.dumps(link)}")
        page.run("new Promise(done => setTimeout(done, 20))")
        assert page.run("document.querySelectorAll('main script, main img').length") == 0
    page.go("#/schemes")
    assert HOSTILE in page.run("document.querySelector('main').textContent")
    assert not complaints_of(page)
