"""What a reader of the site never loads is taken out of it at the end of a build."""

from pathlib import Path
from typing import Any

from sphinx.application import Sphinx


def _drop_maps(app: Sphinx, failure: Exception | None) -> None:
    """Delete the source maps of the theme: 2 MB that only its developers open."""
    if failure is None and app.builder.format == "html":
        for file in (Path(app.outdir) / "_static").rglob("*.map"):
            file.unlink()


def setup(app: Sphinx) -> dict[str, Any]:
    """Connect to the end of the build."""
    app.connect("build-finished", _drop_maps)
    return {"parallel_read_safe": True}
