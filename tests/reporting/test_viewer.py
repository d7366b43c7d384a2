"""The viewer's script: it is what its sources build, carries the licence of what it contains, and
the page's policy lets only it run.
"""

from __future__ import annotations

import base64
import gzip
import hashlib
import re
import shutil
import subprocess
from importlib.resources import files
from pathlib import Path

import pytest

import lostmotion
from lostmotion.reporting.page.document import page
from lostmotion.reporting.page.viewer import scripts

ROOT = Path(__file__).parents[2]
FOLDER = ROOT / "viewer"
SCRIPT = files("lostmotion.reporting.page").joinpath("viewer.js")
needs_sources = pytest.mark.skipif(
    not FOLDER.is_dir(), reason="the sources of the viewer are not part of this copy"
)


@needs_sources
def test_the_script_was_built_from_these_sources():
    """Whoever changes a source and forgets `npm run build` in viewer/ learns it here, without
    node.
    """
    names = re.search(
        r"const inputs = \[(.*?)\]", (FOLDER / "build.mjs").read_text(encoding="utf-8")
    )[1]
    inputs = re.findall(r'"([^"]+)"', names)
    assert {f"src/{each.name}" for each in (FOLDER / "src").iterdir()} <= set(inputs)
    sources = hashlib.sha256(b"".join((FOLDER / name).read_bytes() for name in inputs)).hexdigest()
    assert f"/*! sources sha256 {sources}\n" in SCRIPT.read_text(encoding="utf-8")


@needs_sources
@pytest.mark.skipif(
    shutil.which("node") is None or not (FOLDER / "node_modules" / "esbuild").is_dir(),
    reason="needs `npm ci` in viewer/",
)
def test_the_same_sources_build_the_same_bytes(tmp_path):
    """Nobody need trust the script in the package: it can be built again."""
    subprocess.run(["node", "build.mjs", str(tmp_path / "viewer.js")], cwd=FOLDER, check=True)
    assert (tmp_path / "viewer.js").read_bytes() == SCRIPT.read_bytes()


@needs_sources
def test_the_lock_names_versions_and_checksums_but_no_host():
    """Modules come from the reader's own registry, and are those that were built with."""
    lock = (FOLDER / "package-lock.json").read_text(encoding="utf-8")
    assert "://" not in re.sub(r'"url": "[^"]*"', "", lock)  # where its authors ask for support
    assert lock.count('"integrity"') == lock.count('"node_modules/')


def test_the_script_carries_the_licence_of_what_it_contains():
    """The MIT licence asks that its text goes with every copy."""
    text = SCRIPT.read_text(encoding="utf-8")
    for words in (
        "Copyright © 2010-2026 three.js authors",
        "Permission is hereby granted, free of charge",
        "SPDX-License-Identifier: MIT",
    ):
        assert words in text


def test_the_policy_of_a_page_lets_the_viewer_run_and_nothing_else():
    """It names the hashes of the loader and of the unpacked script, and no address; a page without
    a picture of an arm allows no script.
    """
    study = lostmotion.study(ROOT / "examples" / "planar-2r.toml", 16, method="analytic")
    plots = study.plots
    written = page(study.sheet, plots, "0")
    policy = re.search(r'Content-Security-Policy" content="([^"]+)"', written)[1]
    packed = re.search(r'<script type="text/plain" id="viewer-code">([^<]+)</script>', written)[1]
    code = gzip.decompress(base64.b64decode(packed)).decode()
    assert code == scripts()[1] == SCRIPT.read_text(encoding="utf-8")
    assert "\r" not in code  # a browser would hash another text
    loader = re.search(r"<script>(.*?)</script>", written, re.DOTALL)[1]
    hashes = [
        f"'sha256-{base64.b64encode(hashlib.sha256(each.encode()).digest()).decode()}'"
        for each in (loader, code)
    ]
    assert f"script-src {' '.join(hashes)};" in policy
    assert policy.startswith("default-src 'none';")
    # without JavaScript the pictures below it are shown
    assert re.search(r'<div class="viewer" [^>]*hidden>', written)
    without = page(study.sheet, [plot for plot in plots if plot.scene is None], "0")
    assert "script-src 'none'" in without
    assert "<script" not in without
