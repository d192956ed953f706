"""Which names a module imports, whether all of its source is read or its imports alone."""

import ast

import pytest

from sdaeverify.store import imports

SOURCES = [
    "import a\nimport b.c as d\nfrom . import e\nfrom ..f import g\n",
    "from a import (\n    b,\n    c as d,  # of d\n)\n\ndef f():\n    import g\n",
    "from a import (b,  # (see c)\n    d)\n",
    "if True: import a\n",
    "import a; import b\n",
    "from a \\\n    import b\n",
    "import a  # (from\nimport b\n",
    "x = f(1,\n  2); import a\n",
    "# -*- coding: latin-1 -*-\nimport a\n",
    "\ufeffimport a\n",
    "x = 1\rimport a\r",
    "try:\n    import a\nexcept ImportError:\n    from b import *\n",
    "match x:\n    case 1:\n        import a\n",
]


def names(source: bytes) -> set[str]:
    """Return the names that a tree of all the source has."""
    return set(imports._names(ast.parse(source), "top.inner"))


@pytest.mark.parametrize("text", SOURCES)
def test_no_import_is_missed(text, tmp_path):
    """Whatever is left out before the source is parsed, it is no import."""
    source, file = text.encode(), tmp_path / "module.py"
    file.write_bytes(source)

    assert set(imports.find_imports("top.inner.module", file)) == names(source)


def test_imports_in_texts_may_count():
    """What looks like an import in a text counts only where it is one to the letter."""
    assert imports._statements_alone(b'"""Words.\n\nfrom one step to\n"""\nimport a\n') == b"import a"
    tree = imports._parse(b'"""import of what\n"""\nimport a\n')
    assert set(imports._names(tree, "")) == {"a"}


@pytest.mark.parametrize("source", [b"import (", b"def", b"\0import a"])
def test_no_python(source, tmp_path):
    """What cannot be read imports nothing."""
    file = tmp_path / "module.py"
    file.write_bytes(source)

    assert imports.find_imports("module", file) == ()
