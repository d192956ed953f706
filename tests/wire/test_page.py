"""The page of the protocol says what the code does."""

import re
from pathlib import Path

from sdaeverify_wire.coefficients import FORMS
from sdaeverify_wire.hello import READERS

PAGE = (Path(__file__).parents[2] / "docs" / "reference" / "wire.md").read_text()


def asked_on_the_page():
    """Return the rows of the table of coefficients: (form, name) and the arguments."""
    found, forms = {}, ()
    for line in PAGE.partition("## What can be asked")[2].partition("Numbers of the form")[0].splitlines():
        cells = [cell.strip() for cell in line.split("|")[1:-1]]
        if len(cells) != 4 or cells[0] in {"form", "---"}:
            continue
        forms = re.findall(r"`(\w+)`", cells[0]) or forms
        found |= {(form, name): cells[2].strip("`") for form in forms for name in re.findall(r"`(\w+)`", cells[1])}
    return found


def as_on_the_page(text):
    """Return arguments as a table writes them: ``t x:d`` is ``t=1 x=dxP``."""
    pairs = (argument.partition(":") for argument in text.partition(" -> ")[0].split())
    return " ".join(f"{name}={'x'.join([*letters, 'P'])}" if letters else f"{name}=1" for name, _, letters in pairs)


def test_page_names_all_that_can_be_asked():
    """Each coefficient of each form stands in the table with its arguments, and no other does."""
    known = {(form, name): as_on_the_page(text) for form in FORMS for name, text in FORMS[form].answers.items()}
    assert asked_on_the_page() == known


def test_page_names_each_line_of_a_hello():
    """Each line that a program may say stands in the table."""
    table = PAGE.partition("## Hello")[2].partition("## Steps")[0]
    assert set(READERS) == {line.split()[0] for line in re.findall(r"`([a-z]+ [A-Z][^`]*)`", table)}


def test_page_names_each_number_of_a_form():
    """The numbers that a step is sent with are told."""
    told = PAGE.partition("Numbers of the form:")[2].partition("##")[0]
    assert all(f"`{name}`" in told for form in FORMS.values() for name in form.constants)
