"""Settings of the gallery in each kind of build: a program that is not run has a thumbnail."""

import os
import re
import runpy
import sys
from pathlib import Path

import pytest

DOCS = Path(__file__).parents[1] / "docs"
PROGRAMS = sorted(path.name for path in (DOCS / "gallery").glob("plot_*.py"))


def gallery_of(build, monkeypatch):
    """Return the settings of the gallery that docs/conf.py gives to a build, without building."""
    monkeypatch.setattr(os, "environ", {**os.environ, "DOCS_GALLERY": build})
    monkeypatch.setattr(sys, "path", [*sys.path])
    return runpy.run_path(str(DOCS / "conf.py"))["sphinx_gallery_conf"]


def left_out(conf):
    """Return the programs that are shown and not run."""
    return [name for name in PROGRAMS if not re.search(conf["filename_pattern"], f"/gallery/{name}")]


@pytest.mark.parametrize(
    ("build", "least", "most"), [("all", 0, 0), ("few", 1, len(PROGRAMS) - 1), ("none", len(PROGRAMS), len(PROGRAMS))]
)
def test_a_short_build_has_a_thumbnail_for_what_it_leaves_out(build, least, most, monkeypatch):
    """A build of few programs or none leaves some out, and a picture of the site stands for those."""
    conf = gallery_of(build, monkeypatch)

    assert least <= len(left_out(conf)) <= most
    picture = Path(conf["default_thumb_file"])
    assert picture.parent == DOCS / "_static"
    assert "<svg" in picture.read_text()


@pytest.mark.parametrize("default", [True, False])
def test_the_thumbnail_of_a_program_that_is_not_run(default, monkeypatch, tmp_path):
    """sphinx-gallery copies the picture of the settings; without this setting it shows one of its own."""
    gen = pytest.importorskip("sphinx_gallery.gen_rst", reason="needs the dependencies of the site")
    conf = gallery_of("none", monkeypatch)
    picture = Path(conf["default_thumb_file"])
    size = {"thumbnail_size": (160, 112), "compress_images": ()}
    conf |= {"src_dir": str(DOCS), "default_thumb_file": str(picture) if default else None, **size}
    gen.save_thumbnail(tmp_path / "sphx_glr_plot_{0:03}.png", DOCS / "gallery" / PROGRAMS[0], {}, {}, conf)

    (thumbnail,) = (tmp_path / "thumb").iterdir()
    assert (thumbnail.read_bytes() == picture.read_bytes()) is default
