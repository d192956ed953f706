"""The commands ``list`` and ``info``."""

import json

import pytest

from sdaeverify import __version__

KEYS = {"kind", "name", "parameters", "summary", "plugin", "distribution", "version"}
PLUGIN_KEYS = {
    "kind", "name", "distribution", "version", "module", "status", "reason", "schemes", "problems", "measures",
    "further",
}  # fmt: skip


def test_version(call):
    """The version is that of the package."""
    assert call("--version").out == f"sdaeverify {__version__}\n"


def test_no_command(call):
    """Without a command there is the help."""
    assert call().out == call("--help").out


def test_list_of_everything(call, monkeypatch):
    """All four kinds are listed, each thing on one line where the output is no terminal of a known width."""
    monkeypatch.delenv("COLUMNS")
    outcome = call("list")

    assert (outcome.code, outcome.err) == (0, "")
    (line,) = [line for line in outcome.out.splitlines() if line.startswith("half-explicit-euler ")]
    assert "truncation=theory, no_root=hold HolonomicSDAE Position along the old normal" in " ".join(line.split())
    assert line.rstrip().endswith("sdaeverify-schemes.projections.half_explicit_euler")
    assert "sdaeverify-schemes.milstein" in outcome.out


@pytest.mark.parametrize("columns", ["60", "100"])
def test_a_list_heeds_the_columns_that_are_asked_for(call, monkeypatch, columns):
    """Also where a pager reads it: no line is longer than COLUMNS, which are used."""
    monkeypatch.setenv("COLUMNS", columns)

    assert 0.75 * int(columns) < max(map(len, call("list", "measures").out.splitlines())) <= int(columns)


def test_a_list_that_is_too_wide_is_paragraphs(call, odd_scheme):
    """No name and no word is broken; what a table would have in narrow columns is below the name."""
    lines = call("list", "--plugin", odd_scheme("return Step(state)")).out.splitlines()

    at = lines.index("half-explicit-euler (HolonomicSDAE)")
    assert lines[at + 1 : at + 4] == [
        "    Position along the old normal onto the constraint, velocity along the old",
        "    normal onto the tangent space.",
        "    parameters: truncation=theory, no_root=hold",
    ]
    assert lines[lines.index("odd (SDE)") + 1] == "    from plugin odd_plugin"
    assert "sdaeverify-measures.strong (loaded, 1 measure)" in lines


def test_list_on_a_terminal(call, monkeypatch):
    """On a terminal nothing is wider than the terminal."""
    monkeypatch.setenv("FORCE_COLOR", "1")
    monkeypatch.setenv("NO_COLOR", "1")
    monkeypatch.setenv("TERM", "dumb")

    assert max(map(len, call("list").out.splitlines())) <= 80


@pytest.mark.parametrize("kind", ["schemes", "problems", "measures"])
def test_json_of_one_kind(call, kind):
    """One kind is a list of objects with stable keys."""
    records = json.loads(call("list", kind, "--json").out)

    assert all(set(record) - {"form", "on_request"} == KEYS for record in records)
    assert {record["kind"] for record in records} == {kind.removesuffix("s")}
    assert [record["name"] for record in records] == sorted(record["name"] for record in records)


def test_json_of_everything(call):
    """All kinds are an object of lists, the same as one by one."""
    everything = json.loads(call("list", "--json").out)

    assert list(everything) == ["schemes", "problems", "measures", "plugins"]
    for kind, records in everything.items():
        assert json.loads(call("list", kind, "--json").out) == records
    assert all(set(record) == PLUGIN_KEYS for record in everything["plugins"])
    (pendulum,) = [record for record in everything["problems"] if record["name"] == "pendulum"]
    assert pendulum["parameters"]["c_g"] == 1.0
    assert pendulum["plugin"] == "sdaeverify-problems.pendulums.pendulum"


def test_plugin_file_is_listed(call, odd_scheme):
    """A plugin file is listed with its path, its scheme without docstring with an empty summary."""
    plugin = odd_scheme("return Step(state)")
    records = json.loads(call("list", "--json", "--plugin", plugin).out)

    (scheme,) = [record for record in records["schemes"] if record["name"] == "odd"]
    assert (scheme["summary"], scheme["plugin"], scheme["distribution"]) == ("", "odd_plugin", "")
    assert records["plugins"][-1]["module"] == plugin


def test_status_of_plugins(call, monkeypatch):
    """The list of plugins gives status and reason."""
    monkeypatch.setenv("SDAEVERIFY_DISABLED_PLUGINS", "sdaeverify-schemes.milstein")
    monkeypatch.delenv("COLUMNS")

    outcome = call("list", "plugins")

    (line,) = [line for line in outcome.out.splitlines() if "schemes.milstein " in line]
    assert "disabled" in line
    assert "named in SDAEVERIFY_DISABLED_PLUGINS" in line


@pytest.mark.parametrize(
    ("name", "words"),
    [
        (
            "half-explicit-euler[truncation=none]",
            [
                "scheme half-explicit-euler[truncation=none]",
                "    v+ = v + M^{-1} [ eta h a + B dw + grad g(r) lambda ],         Dg(r+) v+ = 0          (3.10b)",
                "  truncation = theory  (a word or a number)",
                "form: HolonomicSDAE",
                "  drift: round-off",
                "source: Lindner & Stroot 2017",
                "from plugin sdaeverify-schemes.projections.half_explicit_euler (sdaeverify ",
            ],
        ),
        (
            "pendulum[c_g=2]",
            [
                "problem pendulum[c_g=2]",
                "    dtheta = omega dt,",
                "  c_g = 1.0  (a number)",
                "horizon: 0.5",
                "units: length of the pendulum 1",
                "traits: additive-noise, commutative-noise, constrained, no-delay, vanishing-milstein-term",
                "observables: r_1, r_2, v_1",
                "  the path, by a reference of strong order 1.5 (order 3/2",
                "  E energy at every time (Ito's formula",
            ],
        ),
        ("ou", ["  the path, exact (Kloeden", "  mean-square "]),
        ("strong", ["measure strong", "from plugin sdaeverify-measures.strong"]),
        ("sdaeverify-schemes.milstein", ["plugin sdaeverify-schemes.milstein", "status: loaded"]),
        ("sdaeverify-planted.higher_orders", ["plugin sdaeverify-planted.higher_orders", "status: loaded"]),
        ("HolonomicSDAE", ["form HolonomicSDAE", "schemes that solve it: explicit-projection-euler, half-explicit"]),
        (
            "SDE",
            ["form SDE", "A stochastic differential equation dx = f dt + B dW (Ito).", "problems of this form: cir"],
        ),
        (
            "IndexOneSDAE",
            ["schemes that solve it: drift-implicit-milstein, lagged-algebraic-theta", "problems of this form: "],
        ),
        ("Scheme", ["sdaeverify.Scheme"]),
        ("traits", ["additive-noise", "  The diffusion matrix depends neither", "  asked for by claims of: heun"]),
        ("noise", ["Noise of one step: l Brownian motions", "schemes that need H: ", "schemes that need dW: "]),
        ("claims", ["A property that a scheme's author claims.", "schemes with claims about strong: "]),
        ("measures", ["drift", "  Violation of each constraint along the paths."]),
    ],
)
def test_info(call, name, words):
    """All that is known of a thing, equations as they were written."""
    outcome = call("info", name)

    assert (outcome.code, outcome.err) == (0, "")
    assert [line for line in words if not any(found.startswith(line) for found in outcome.out.splitlines())] == []
