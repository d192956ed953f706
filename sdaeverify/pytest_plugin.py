"""The pytest plugin: markers of the kit, and a section of the report with the outcomes of its tests.

pytest loads it in every run, and most runs do not test schemes, so it imports no other module of the package.
"""

from collections import Counter

import pytest

# Name of the test property that holds the part of the kit; xdist sends it to the main process.
PROPERTY = "sdaeverify"
# Attribute of the class of a test's parameter that names the part of the kit.
PART = "sdaeverify_part"
MARKERS = (
    "hunt: counterexamples of claims are looked for (sdaeverify)",
    "benchmark: steps of schemes are timed (sdaeverify, pytest-benchmark)",
    "sdaeverify: a check, claim, hunt or timing of the kit; given to the tests by the plugin",
)
OUTCOMES = ("passed", "failed", "error", "skipped", "xfailed", "xpassed")


def pytest_configure(config: pytest.Config) -> None:
    """Register the markers, so that a project with --strict-markers does not have to."""
    for marker in MARKERS:
        config.addinivalue_line("markers", marker)


def pytest_collection_modifyitems(items: list[pytest.Item]) -> None:
    """Add the marker ``sdaeverify`` and a property, the part of the kit, to each test of the kit."""
    for item in items:
        parameters = getattr(getattr(item, "callspec", None), "params", {}).values()
        kinds = (type(each) for each in parameters)
        parts = [part for kind in kinds if isinstance(part := vars(kind).get(PART), str)]
        if parts:
            item.add_marker("sdaeverify")
            item.user_properties.append((PROPERTY, parts[0]))


def pytest_terminal_summary(terminalreporter: pytest.TerminalReporter) -> None:
    """Write one line for each part of the kit with the number of its tests by outcome."""
    counts = dict[str, Counter[str]]()
    for outcome in OUTCOMES:
        for report in terminalreporter.stats.get(outcome, ()):
            part = dict(getattr(report, "user_properties", ())).get(PROPERTY)
            if isinstance(part, str):
                counts.setdefault(part, Counter())[outcome] += 1
    if counts:
        terminalreporter.write_sep("=", "sdaeverify")
        for part, found in sorted(counts.items()):
            listed = ", ".join(f"{found[outcome]} {outcome}" for outcome in OUTCOMES if found[outcome])
            terminalreporter.write_line(f"{part}: {listed}")
