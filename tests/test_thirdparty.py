"""Distributions of others, built and installed by pip: found, listed and verified; broken ones cost themselves."""

import json
import os
import subprocess
import sys
from pathlib import Path

import pytest

from evidence import rows_of
from facade import ExitCode

pytestmark = pytest.mark.long

THIRDPARTY = Path(__file__).parent / "thirdparty"
DISTRIBUTIONS = ("broken", "energy", "geodesic", "jump_diffusion", "stages")


@pytest.fixture(scope="module")
def site(tmp_path_factory):
    """Build and install all of them into a folder of their own, without a network."""
    folder = tmp_path_factory.mktemp("site")
    pip = [sys.executable, "-m", "pip", "install", "--quiet", "--disable-pip-version-check"]
    paths = [str(THIRDPARTY / name) for name in DISTRIBUTIONS]
    command = [*pip, "--no-deps", "--no-index", "--no-build-isolation", "--target", str(folder), *paths]
    subprocess.run(command, check=True, capture_output=True)
    return folder


@pytest.fixture
def run(site, tmp_path):
    """Run a command line of Python with these distributions installed."""

    def execute(*words, disabled="", cwd=tmp_path):
        environment = {**os.environ, "PYTHONPATH": str(site), "SDAEVERIFY_DISABLED_PLUGINS": disabled}
        command = [sys.executable, "-m", *words]
        return subprocess.run(command, capture_output=True, text=True, check=False, cwd=cwd, env=environment)

    return execute


def rows(folder):
    """Return the rows of a run's verdicts."""
    return rows_of(folder / "verdicts.csv")


def verdicts(folder, scheme):
    """Return the verdicts on a scheme, and the reasons of those that are none."""
    found = [row for row in rows(folder) if row["scheme"] == scheme]
    return {row["verdict"] for row in found}, {row["reason"] for row in found}


@pytest.fixture(scope="module")
def listed(site):
    """List everything that is installed."""
    environment = {**os.environ, "PYTHONPATH": str(site)}
    command = [sys.executable, "-m", "sdaeverify", "list", "--json"]
    found = subprocess.run(command, capture_output=True, text=True, check=True, env=environment)
    return json.loads(found.stdout)


def test_plugins_are_listed_with_distribution_and_version(listed):
    """Schemes and problems of others are found by their entry points and carry who brought them."""
    entries = {entry["name"]: entry for kind in ("schemes", "problems") for entry in listed[kind]}

    for name, distribution in {
        "geodesic-baoab": "sdaeverify-geodesic",
        "ellipse-langevin": "sdaeverify-geodesic",
        "jump-euler": "sdaeverify-jumps",
        "sound-euler": "sdaeverify-broken",
    }.items():
        assert (entries[name]["distribution"], entries[name]["version"]) == (distribution, "0.1.0")


def test_plugin_that_fails_to_load_costs_nothing_else(listed):
    """It is left out with its reason; all other plugins are loaded, also those of that distribution."""
    plugins = {row["name"]: row for row in listed["plugins"]}
    broken = plugins.pop("broken-import")

    assert broken["status"] == "broken"
    assert "ImportError: this plugin needs a library that is not there" in broken["reason"]
    # What needs a library that is not installed is absent; what few commands need is loaded on request.
    assert {row["status"] for row in plugins.values()} <= {"loaded", "absent", "on request"}
    assert plugins.keys() >= {"sound", "broken-step", "broken-hang", "broken-memory"}


@pytest.mark.slow
def test_scheme_that_raises_hangs_or_hoards_costs_its_own_rows(run, tmp_path):
    """What raises, never returns or takes all memory is in error, with the reason; its neighbour is verified."""
    schemes = "sound-euler,raising-euler,hanging-euler,hoarding-euler"
    words = ["matrix", "-s", schemes, "-p", "gbm", "-m", "strong", "--paths", "500", "-j", "2"]
    limits = ["--timeout", "10", "--memory", "1G", "--progress", "none", "--out", str(tmp_path)]

    ended = run("sdaeverify", *words, *limits)

    assert ended.returncode == ExitCode.NOT_MEASURED, ended.stderr
    assert verdicts(tmp_path, "sound-euler")[0] == {"verified"}
    for scheme, reason in {
        "raising-euler": "ZeroDivisionError: a step that cannot be made",
        "hanging-euler": "--timeout",
        "hoarding-euler": "--memory",
    }.items():
        found, (why,) = verdicts(tmp_path, scheme)
        assert found == {"error"}
        assert reason in why


def test_form_with_its_own_noise_is_verified_and_refuted(run, tmp_path):
    """T0 refutes compensated jumps, and Marcus' ones where the equation has others; T1 verifies Euler's."""
    problems = "geometric-jumps,shot-noise"
    words = ["-s", "*jump-euler", "-p", problems, "-m", "strong,weak", "-j", "1", "--paths", "2048"]

    ended = run("sdaeverify", "matrix", *words, "--out", str(tmp_path), disabled="sdaeverify-broken")

    assert ended.returncode == ExitCode.REFUTED, ended.stdout + ended.stderr
    cells = [row for row in rows(tmp_path) if not row["problem"].startswith("every-equation")]
    found = {(row["scheme"], row["measure"], row["decided_by"], row["verdict"]) for row in cells}
    assert {tuple(each[1:3]) for each in found if each[0] == "compensated-jump-euler"} == {
        ("strong", "T0"),
        ("weak", "T0"),
    }
    assert {each[3] for each in found if each[0] == "compensated-jump-euler"} == {"refuted"}
    assert ("jump-euler", "strong", "T1", "verified") in found
    assert ("marcus-jump-euler", "strong", "T0", "refuted") in found
    assert ("marcus-jump-euler", "weak", "T0", "refuted") in found
    assert not [each for each in found if each[0] == "jump-euler" and each[3] == "refuted"]


@pytest.mark.slow
def test_geodesic_scheme_is_verified(run, tmp_path):
    """The stationary means of geodesic BAOAB tend to the exact ones on the ellipse, with order 2."""
    words = ["-s", "geodesic-baoab", "-p", "ellipse-langevin", "-m", "invariant", "-j", "1"]

    ended = run("sdaeverify", "matrix", *words, "--out", str(tmp_path), disabled="sdaeverify-broken")

    assert ended.returncode == ExitCode.OK, ended.stdout + ended.stderr
    assert verdicts(tmp_path, "geodesic-baoab")[0] == {"verified"}
    orders = [float(row["value"]) for row in rows(tmp_path)]
    assert orders == pytest.approx([2.0] * 4, abs=0.01)


def test_measures_of_others_tell_a_right_claim_from_a_wrong_one(run, tmp_path):
    """Milstein keeps energy with order 1 along paths and 3/2 in one step; without his correction it is 1/2 less."""
    measures = "energy-drift,energy-defect"
    words = ["matrix", "-s", "kubo-*", "-p", "kubo-oscillator", "-m", measures, "--paths", "1024", "-j", "1"]

    ended = run("sdaeverify", *words, "--out", str(tmp_path), disabled="sdaeverify-broken")

    assert ended.returncode == ExitCode.REFUTED, ended.stdout + ended.stderr
    assert verdicts(tmp_path, "kubo-milstein")[0] == {"verified"}
    assert verdicts(tmp_path, "kubo-forgetful")[0] == {"refuted"}
    for scheme, order in (("kubo-milstein", 1.0), ("kubo-forgetful", 0.5)):
        of = {row["measure"]: row for row in rows(tmp_path) if row["scheme"] == scheme}
        drift, defect = of["energy-drift"], of["energy-defect"]
        # Orders of steps of a finite length are off by more than chance, if by less than the margin of a claim.
        assert abs(float(drift["path_order"]) - order) < float(drift["margin"])
        assert defect["decided_by"] == "T1"
        assert float(defect["local_order"]) == pytest.approx(order + 0.5, abs=0.01)


@pytest.mark.parametrize(
    ("module", "rooms"), [("energy_drift", {"measuring as m"}), ("energy_defect", {"measuring as m", "probing as p"})]
)
def test_measures_of_others_are_written_with_public_names_alone(module, rooms):
    """Each is short, and imports nothing of the framework but `sdaeverify` and its rooms for authors of measures."""
    source = (THIRDPARTY / f"energy/src/sdaeverify_energy/{module}.py").read_text(encoding="utf-8")
    imports = {line for line in source.splitlines() if "sdaeverify" in line and line.startswith(("import", "from"))}

    assert len(source.splitlines()) <= 80
    assert imports == {*(f"import sdaeverify.{room}" for room in rooms), "from sdaeverify import hookimpl"}
