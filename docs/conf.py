"""The site: pages, passports, examples that are run; `python -m sphinx -W docs docs/_site` builds it."""

import os
import sys
from pathlib import Path

import sdaeverify

HERE = Path(__file__).parent
ROOT = HERE.parent
sys.path[:0] = [str(HERE / "_ext"), str(ROOT / "tests"), str(ROOT / "tests/thirdparty/jump_diffusion/src")]
# Commands that pages run are told in as many columns as a page has, and take what cores are left.
os.environ |= {"COLUMNS": "100", "NO_COLOR": "1", "OMP_NUM_THREADS": "1", "MPLBACKEND": "agg"}

from counts import counts  # noqa: E402 - the folder of extensions has just been named
from gallery import gallery_conf  # noqa: E402

SWITCHER = os.environ.get("DOCS_SWITCHER")

project = "sdaeverify"
author = "The authors of sdaeverify"
version = release = sdaeverify.__version__
extensions = [
    "myst_parser",
    "sphinx.ext.autodoc",
    "sphinx_design",
    "docstrings",
    "mathml",
    "numpydoc",
    "sphinx_gallery.gen_gallery",
    "running",
    "generated",
    "narrow",
    "slimming",
    "checking",
]
exclude_patterns = [
    "_site",
    "_ext",
    "gallery/*.py",
    "gallery/README.txt",
    "generated/pieces",
]
default_role = "py:obj"
suppress_warnings = ["config.cache"]  # sphinx-gallery keeps functions in its settings

myst_enable_extensions = ["colon_fence", "substitution", "deflist", "dollarmath", "fieldlist"]
myst_heading_anchors = 3
myst_dmath_double_inline = False
html_math_renderer = "mathml"  # no script, no network
myst_substitutions = counts(ROOT / "reports" / "reference")

autodoc_member_order = "bysource"
autodoc_typehints = "none"
numpydoc_show_class_members = False
numpydoc_class_members_toctree = False
sphinx_gallery_conf = gallery_conf(HERE)

html_theme = "pydata_sphinx_theme"
html_title = "sdaeverify"
html_copy_source = html_show_sourcelink = False
html_context = {"default_mode": "auto"}
html_favicon = "_static/mark.svg"
html_static_path = ["_static"]
html_css_files = ["site.css"]
html_search_scorer = str(HERE / "_ext" / "scorer.js")
html_sidebars = {name: [] for name in ("index", "install", "tutorial", "project")}  # pages without pages below them
html_theme_options = {
    "secondary_sidebar_items": ["page-toc"],
    "navigation_with_keys": False,
    # Each of 470 pages would list all of them at its side: 35 of 39 MB of the site.
    "collapse_navigation": True,
    "use_edit_page_button": False,
    "logo": {"text": f"sdaeverify {version}"},
    # A host of several versions names a file of them in DOCS_SWITCHER; without it a page tells its own version.
    "navbar_end": [*(["version-switcher"] if SWITCHER else []), "theme-switcher"],
    "navbar_persistent": ["search-button-field"],
    "switcher": {"json_url": SWITCHER or "", "version_match": version},
    "check_switcher": False,
    "show_version_warning_banner": bool(SWITCHER),
}
