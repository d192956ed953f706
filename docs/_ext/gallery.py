"""Settings of the gallery: its programs are run while the site is built."""

import os
from pathlib import Path
from typing import Any

# DOCS_GALLERY says which programs are run, all if it is not set: few in CI, none while one writes pages.
PATTERNS = {"all": r"/plot_", "few": r"/plot_(cart|cir|kubo|tree)", "none": r"/nothing"}


def gallery_conf(here: Path) -> dict[str, Any]:
    """Return the settings: what DOCS_GALLERY names is run, the rest is shown as it is written."""
    return {
        "examples_dirs": [str(here / "gallery")],
        "gallery_dirs": ["gallery_pages"],
        "filename_pattern": PATTERNS[os.environ.get("DOCS_GALLERY", "all")],
        "within_subsection_order": "FileNameSortKey",
        "abort_on_example_error": True,
        # Its page asks another place for a script.
        "write_computation_times": False,
        # Of a program that is not run in this build, or draws nothing.
        "default_thumb_file": str(here / "_static" / "mark.svg"),
        "download_all_examples": False,
        "capture_repr": ("_repr_html_",),
        "remove_config_comments": True,
        "min_reported_time": 0,
        "show_memory": False,
        "reset_modules": ("matplotlib",),
    }
