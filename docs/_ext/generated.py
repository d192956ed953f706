"""Pages that are made of what is registered, of docstrings and of the reference run; nobody writes them by hand."""

from hashlib import sha256
from pathlib import Path
from typing import Any

from findings import finding_pages
from kept import kept_pages
from mistakes import mistake_pages
from names import name_pages
from passports import passport_pages
from reference import reference_pages
from sphinx.application import Sphinx

FOLDER = "generated"
MADE_OF = ("sdaeverify", "plugins", "problems", "tests/testing", "reports", "docs/_ext")
READ = {".py", ".csv", ".json", ".jsonl"}


def _write(app: Sphinx) -> None:
    """Write what has changed, so that a second build makes and reads no page again without need."""
    root, folder = Path(app.srcdir).parent, Path(app.srcdir) / FOLDER
    stamp, known = folder / "stamp", _fingerprint(root)
    if stamp.exists() and stamp.read_text() == known:
        return
    reference = root / "reports" / "reference"
    pages = {
        **reference_pages(),
        **name_pages(),
        **finding_pages(reference),
        **kept_pages(root / "reports"),
        **mistake_pages(),
        **passport_pages(folder / "pictures", reference),
    }
    for name, text in pages.items():
        path = folder / name
        path.parent.mkdir(parents=True, exist_ok=True)
        if not path.exists() or path.read_text() != text:
            path.write_text(text)
    for path in [*folder.rglob("*.md"), *folder.rglob("*.rst")]:
        if path.relative_to(folder).as_posix() not in pages:
            path.unlink()
    stamp.write_text(known)


def _fingerprint(root: Path) -> str:
    """Return a hash of all that the pages are made of."""
    files = [path for place in MADE_OF for path in sorted((root / place).rglob("*")) if path.suffix in READ]
    return sha256(b"".join(path.read_bytes() for path in [*files, root / "pyproject.toml"])).hexdigest()


def setup(app: Sphinx) -> dict[str, Any]:
    """Write the pages before any is read."""
    app.connect("builder-inited", _write)
    return {"parallel_read_safe": True}
