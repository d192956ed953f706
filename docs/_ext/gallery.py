"""Settings of the gallery: its programs are run while the site is built."""

import os
from pathlib import Path
from typing import Any

# Those that CI runs; SDAEVERIFY_GALLERY=all, the default, runs every one of them.
FEW = r"/plot_(kubo|rlc)"


def gallery_conf(here: Path) -> dict[str, Any]:
    """Return the settings: what SDAEVERIFY_GALLERY names is run, the rest is shown as it is written."""
    wanted = os.environ.get("SDAEVERIFY_GALLERY", "all")
    return {
        "examples_dirs": [str(here / "gallery")],
        "gallery_dirs": ["gallery_pages"],
        "filename_pattern": FEW if wanted == "few" else r"/plot_",
        "within_subsection_order": "FileNameSortKey",
        "abort_on_example_error": True,
        "download_all_examples": False,
        "remove_config_comments": True,
        "min_reported_time": 0,
        "show_memory": False,
        "reset_modules": ("matplotlib", _warnings_are_errors),
    }


def _warnings_are_errors(conf: dict[str, Any], name: str) -> None:
    """Do nothing yet: an example that warns is told by Sphinx."""
