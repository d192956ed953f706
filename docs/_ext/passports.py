"""Passports of schemes, problems and measures, from the registry and from the reference run, with pictures."""

from collections import Counter, defaultdict
from collections.abc import Iterable, Mapping
from pathlib import Path
from typing import Any

import numpy as np
from formulas import described, summary
from markup import page, prose, table, toctree
from matplotlib import pyplot as plt

from sdaeverify import sample
from sdaeverify.contracts.scheme import form_names
from sdaeverify.errors import SdaeverifyError
from sdaeverify.registry.load import Registry, load_registry
from sdaeverify.report.folders import read_verdicts
from sdaeverify.report.passports import measure_passport, problem_passport, scheme_passport
from sdaeverify.report.plots import Plots
from sdaeverify.report.verdict_row import VerdictRow

# Labels as text, not as outlines: a picture is a third smaller, and its words can be searched.
plt.rcParams["svg.fonttype"] = "none"
Rows = list[VerdictRow]
STEPS, PATHS, MOST = 64, 12, 40
SIGNS = {"verified": "✓", "refuted": "✗", "inconclusive": "?", "error": "!", "diverged": "∞", "out_of_scope": "○"}
LEGEND = "Numbers of quantities: " + ", ".join(f"{sign} {verdict}" for verdict, sign in SIGNS.items()) + "."
RUN_ON_REQUEST = "It runs only on request: name it with `-p`."


def passport_pages(pictures: Path, reference: Path) -> dict[str, str]:
    """Return the pages by name, and draw their pictures into a folder."""
    registry = load_registry(environ={})
    rows = [VerdictRow.from_row(row) for row in read_verdicts(reference).verdicts]
    pictures.mkdir(parents=True, exist_ok=True)
    schemes = {name: entry.thing for name, entry in sorted(registry.schemes.items())}
    pages = {f"schemes/{name}.md": _scheme(scheme, rows, pictures) for name, scheme in schemes.items()}
    pages |= {f"problems/{name}.md": _problem(name, registry, rows, pictures) for name in sorted(registry.problems)}
    return {
        **pages,
        "measures.md": _measures(registry),
        "schemes.md": page(
            "Schemes",
            "The shipped schemes.",
            table(
                ["scheme", "form", "summary"],
                (
                    [f"[{name}](schemes/{name}.md)", form_names(s), _summary(scheme_passport(s))]
                    for name, s in schemes.items()
                ),
            ),
            toctree(f"schemes/{name}" for name in schemes),
        ),
        "problems.md": page(
            "Problems",
            "The shipped problems. A problem is a function of its parameters.",
            table(
                ["problem", "form", "summary"],
                (
                    [f"[{name}](problems/{name}.md)", passport.get("form", ""), _summary(passport)]
                    for name, passport in ((name, _passport(name, registry)) for name in sorted(registry.problems))
                ),
            ),
            toctree(f"problems/{name}" for name in sorted(registry.problems)),
        ),
    }


def _summary(passport: Mapping[str, Any]) -> str:
    return summary(passport["text"].partition("\n")[0])


def _passport(name: str, registry: Registry) -> dict[str, Any]:
    spec = registry.problems[name].make({})
    return problem_passport(spec, spec.build())


def _scheme(scheme: Any, rows: Rows, pictures: Path) -> str:
    told = scheme_passport(scheme)
    claims = (
        [
            c["measure"],
            f"`{c['claim']}`",
            ", ".join(c["quantities"]) or "all",
            ", ".join(c["when"]),
            str(c["margin"]) if c["claim"].startswith("order") else "",
            prose(c["source"]),
        ]
        for c in told["claims"]
    )
    own = [row for row in rows if row.scheme.partition("[")[0] == scheme.name]
    return page(
        scheme.name,
        described(told["text"]),
        f"Form: {told['form']}. Source: {prose(told['source'] or 'that of its claims')}.",
        _parameters(told["parameters"]),
        "## Claims",
        table(["measure", "claim", "quantities", "required traits", "margin", "source"], claims)
        if told["claims"]
        else "None.",
        "## Results of the reference run",
        _found(own, "problem", "problems"),
        _orders(own, pictures / f"scheme-{scheme.name}.svg"),
        _again(f"info {scheme.name}"),
    )


def _problem(name: str, registry: Registry, rows: Rows, pictures: Path) -> str:
    told = _passport(name, registry)
    own = [row for row in rows if row.problem.partition("[")[0] == name]
    facts = [
        f"Form {told['form']}",
        f"{told['noise']} Brownian motions",
        f"horizon {told['horizon']:g}",
        prose(told["units"] or ""),
    ]
    controls = (
        [c["measure"], f"{c['order']:g}", f"`{c['positive']}`", f"`{c['negative']}`"] for c in told["controls"]
    )
    return page(
        name,
        described(told["text"]),
        "; ".join(filter(None, facts)) + ". " + ("" if own else RUN_ON_REQUEST),
        f"Traits: {', '.join(f'`{trait}`' for trait in told['traits'])}." if told["traits"] else "",
        _parameters(told["parameters"]),
        "## What is known exactly",
        "\n".join(f"- {prose(truth)}" for truth in told["truths"]) or "None.",
        "## Controls" if told["controls"] else "",
        table(["measure", "order", "has it", "has it not"], controls) if told["controls"] else "",
        _paths(name, own, pictures / f"problem-{name}.svg"),
        "## Results of the reference run" if own else "",
        _found(own, "scheme", "schemes") if own else "",
        _again(f"info {name}"),
    )


def _parameters(given: Mapping[str, str]) -> str:
    return "Parameters: " + ", ".join(f"`{key}={value}`" for key, value in given.items()) + "." if given else ""


def _again(command: str) -> str:
    return f"In a terminal: `sdaeverify {command}`."


def _found(rows: Rows, key: str, folder: str) -> str:
    """Return counts of verdicts: a row for each counterpart, a column for each measure."""
    cells: dict[str, dict[str, Counter[str]]] = defaultdict(lambda: defaultdict(Counter))
    for row in rows:
        if row.verdict in SIGNS:
            cells[getattr(row, key)][row.measure][row.verdict] += 1
    if not cells:
        return "None: the problem runs only on request."
    measures = sorted({measure for counted in cells.values() for measure in counted})
    lines = (
        [
            f"[{prose(label)}](../{folder}/{label.partition('[')[0]}.md)",
            *(" ".join(f"{SIGNS[v]}{n}" for v, n in counted[measure].most_common()) for measure in measures),
        ]
        for label, counted in sorted(cells.items())
    )
    return table([key, *measures], lines) + f"\n{LEGEND}"


def _orders(rows: Rows, file: Path) -> str:
    """Draw strong orders, at most so many as can be read."""
    known = [row for row in rows if row.measure == "strong" and row.claim]
    try:
        _, ax = plt.subplots(figsize=(8, 1.2 + 0.18 * min(len(known), MOST)), layout="constrained")
        Plots(known[:MOST], []).orders(ax=ax)
        plt.savefig(file, metadata={"Date": None})
    except SdaeverifyError:
        return ""
    finally:
        plt.close("all")
    told = "Strong orders with their intervals: filled along paths, hollow without sampling; the claim in green."
    return f"![strong orders, with claims](../pictures/{file.name})\n\n{told}"


def _paths(name: str, rows: Rows, file: Path) -> str:
    """Draw some paths by a scheme that was run on the problem."""
    for scheme in _candidates(rows):
        try:
            paths = sample(scheme, name, steps=STEPS, paths=PATHS)
        except (SdaeverifyError, np.linalg.LinAlgError):
            continue
        names = list(paths.components)[:3]
        _, axes = plt.subplots(1, len(names), figsize=(3.6 * len(names), 2.6), squeeze=False, layout="constrained")
        for component, ax in zip(names, axes[0], strict=True):
            paths.plot(component, ax=ax).set_title("")
        plt.savefig(file, metadata={"Date": None})
        plt.close("all")
        return f"![paths of {name}](../pictures/{file.name})\n\n{PATHS} paths by {scheme}, {STEPS} steps."
    return ""


def _candidates(rows: Rows) -> Iterable[str]:
    """Return schemes that were run, those with most verified first; then what solves most forms."""
    verified = Counter(row.scheme for row in rows if row.verdict == "verified")
    usual = [
        "half-explicit-euler",
        "semi-implicit-projection-euler",
        "constrained-euler",
        "uniformly-accurate",
        "stochastic-theta",
        "euler-maruyama",
    ]
    return [*(name for name, _ in verified.most_common(3)), *usual]


def _measures(registry: Registry) -> str:
    told = (measure_passport(entry.thing) for _, entry in sorted(registry.measures.items()))
    return page(
        "Measures",
        "The quantities of each measure, and how claims about them are judged.",
        *(f"## {p['label']}\n\n{described(p['text'])}" for p in told),
    )
