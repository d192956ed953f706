"""The pictures of the architecture page: `python docs/ways.py` writes docs/_static/cell.svg and way.svg.

Words in backquotes are names of the code, which `tests/test_contributing.py` looks up, those in
asterisks are headings.
"""

import re
from html import escape
from pathlib import Path

HERE = Path(__file__).parent
WIDTH, LINE, GAP = 660, 19, 22
HEAD = """<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 {width} {height}" role="img"
 width="{width}" height="{height}">
<title>{title}</title>
<style>
text { font: 13px sans-serif; fill: #222; white-space: pre; }
.code { font: 12.5px ui-monospace, Menlo, Consolas, monospace; fill: #124d7c; }
.head { font-weight: bold; }
.box { fill: #f4f7fa; stroke: #7a8a99; }
.worker { fill: #fdf6e7; stroke: #b08c3a; }
.way { fill: none; stroke: #444; stroke-width: 1.3; marker-end: url(#tip); }
</style>
<defs><marker id="tip" viewBox="0 0 8 8" refX="7" refY="4" markerWidth="8" markerHeight="8" orient="auto">
<path d="M0 0 8 4 0 8z" fill="#444"/></marker></defs>
<rect width="{width}" height="{height}" fill="#fff"/>
"""

# The life of a cell, from top to bottom.
SELECT = "*Select*  `cli/commands/matrix.py`\n`plan_of`: schemes, problems and measures from the `Registry`"
PLAN = """*Plan*  `study/plan.py`
`plan`: `match` gives the view, `Measure.refuses` the refusals;
`Plan` of `ProblemPlan` of `Cell`, with the controls"""
DISTRIBUTE = """*Distribute*  `study/run.py`
`Study.run`: `Study._screen` once, then `Study._look` by look;
one `ProblemRun` a problem, `ProblemRun.task` gives its `Task`;
`Blocks.results` reads the `Store`, or sends blocks to workers"""
MEASURE = """*Measure*, in a worker  `simulate/ensemble.py`
`run_block` on block `SCREENING`, without paths:
  `violation`: contract and exactness (T0)
  `Measure.probe`: one step, moments (T1, T2)
`run_block` on blocks of paths (T3):
  `Brownian` noise drives the `SchemeTracks` of all schemes
  the `Observer` of each measure fills its `Tally`"""
JUDGE = """*Judge*, in a worker  `study/problem_run.py`, `study/judging.py`
`ProblemRun.absorb` merges blocks into `CellEvidence`;
`judge_cell`: `Measure.judge`, then the rules;
`CellRun` keeps the `CellResult` of its last look"""
COMPARE = """*Compare*  `study/agreement.py`, `study/holm.py`
`agreeing`: with other findings on the problem;
`family_wise`: over all tests of the run"""
REPORT = """*Report*  `report/tables/rows.py`, `report/html`
`rows_of` makes each `Finding` a `VerdictRow`;
`Result.save` writes the tables, `write_page` the page;
`code_of_results` gives the exit code"""

# The way of a verdict.
COVERAGE = "*Coverage*  `verdicts/coverage.py`\n`coverage`: the strongest `Claim` about the quantity, or the gap"
ONE_STEP = """*One step*  `measures/strong/findings.py`
`local_orders` reads the probes:
  `StrongOrder`
`judge_order` compares it with the claim
guards `OF_ONE_STEP`: `of_smooth` ..
gives an `Opinion` of tier T1, or none"""
PATHS = """*Paths*  `measures/path_errors/order.py`
`quantities_of` reads the tally: `Quantity`
`usable_levels`, `fit`: `Fit` of the order
`path_tests` finds p-values
guards `OF_PATHS`: `hold_back` ..
gives `PathTests`"""
OPINION = """*Opinion*  `verdicts/opinions.py`
`guard`: paths guard what one step verifies; `decide`: they decide the rest
`finding`: the `Finding`, with verdict, reason, method, p-values
guard `OF_CELLS`: `withhold_in_doubt`, over all quantities of the cell"""
RULES_HEAD = """*Rules*  `verdicts/rules.py`: `send` applies `RULES` in this order.
A rule changes nothing if its field of `Case` is empty. Who fills it:"""
# By the function that fills the case, the rules in their order and what they do.
RULES = {
    "`judge_cell`, each look": {
        "PROBLEM": "not refuted by paths if a positive control is refuted too",
        "DISCRIMINATION": "not verified unless controls separate the order from lower ones",
        "MOMENTS": "not verified if moments of the scheme tend to infinity",
        "END": "refuted by paths or not decided if the solution ends early",
        "count_looks": "multiplies the p-values by the number of looks",
    },
    "`ProblemRun._mark_for_next_stage`": {"wait_for_finer_levels": "open while finer levels are drawn"},
    "`agreeing`": {"OTHER_FINDINGS": "not verified if a related finding shows a wrong limit"},
    "`_current_result`": {"tell_stop": "adds the reason why sampling stopped"},
    "`family_wise`": {"correct_for_all_tests": "keeps, withdraws or gives verdicts by Holm's procedure"},
    "`outcomes`, in a gate": {"RESOLUTION": "not verified if a gate asks for a finer resolution"},
}
RESULT = "a row of `verdicts.csv`; in a gate, an `Outcome`"


def text(x: float, y: float, words: str) -> str:
    """Return a line of text."""
    marked = re.sub(r"`([^`]*)`", r'<tspan class="code">\1</tspan>', escape(words, quote=False))
    marked = re.sub(r"[*]([^*]*)[*]", r'<tspan class="head">\1</tspan>', marked)
    return f'<text x="{x}" y="{y}">{marked}</text>\n' if words else ""


def height(lines: str) -> int:
    """Return the height of a box."""
    return 12 + LINE * len(lines.split("\n"))


def box(place: tuple[float, float, float], lines: str, kind: str = "box") -> str:
    """Return a box with lines of text; `place` is its left, its top and its width."""
    x, y, width = place
    frame = f'<rect class="{kind}" x="{x}" y="{y}" width="{width}" height="{height(lines)}" rx="4"/>\n'
    return frame + "".join(text(x + 10, y + LINE * (n + 1), each) for n, each in enumerate(lines.split("\n")))


def way(path: str) -> str:
    """Return an arrow."""
    return f'<path class="way" d="{path}"/>\n'


def save(name: str, title: str, drawn: str, bottom: int) -> dict[str, str]:
    """Return a picture by the name of its file."""
    head = HEAD
    for mark, value in {"width": WIDTH, "height": bottom + 12, "title": title}.items():
        head = head.replace(f"{{{mark}}}", str(value))
    return {f"{name}.svg": f"{head}{drawn}</svg>\n"}


def draw_cell() -> dict[str, str]:
    """Return the picture of the life of a cell."""
    left, width, y, drawn, tops = 16, 540, 12, "", {}
    labels = {MEASURE: "`Task`", JUDGE: "`SchemeEvidence`"}
    for lines in (SELECT, PLAN, DISTRIBUTE, MEASURE, JUDGE, COMPARE, REPORT):
        if tops:
            drawn += way(f"M{left + 60} {y} v{GAP}") + text(left + 72, y + 15, labels.get(lines, ""))
            y += GAP
        tops[lines] = y
        drawn += box((left, y, width), lines, "worker" if lines is MEASURE else "box")
        y += height(lines)
    right, again = left + width, "not settled: a look with more paths, or a finer stage"
    drawn += way(f"M{right} {tops[JUDGE] + 30} h36 V{tops[DISTRIBUTE] + 30} h-34")
    drawn += f'<g transform="translate({right + 52} {tops[JUDGE]}) rotate(-90)">{text(0, 0, again)}</g>\n'
    return save("cell", "From a command to a row", drawn, y)


def draw_way() -> dict[str, str]:
    """Return the picture of the way of a verdict."""
    y = 12 + height(COVERAGE)
    drawn = box((100, 12, 460), COVERAGE) + way(f"M230 {y} v{GAP}") + way(f"M440 {y} v{GAP}")
    drawn += box((12, y + GAP, 310), ONE_STEP) + box((334, y + GAP, 314), PATHS)
    y += GAP + height(ONE_STEP)
    drawn += way(f"M230 {y} v{GAP}") + way(f"M440 {y} v{GAP}") + box((60, y + GAP, 540), OPINION)
    y += GAP + height(OPINION)
    rules = [name for filled in RULES.values() for name in filled]
    lines = "\n".join([RULES_HEAD, *[""] * (len(RULES) + len(rules))])
    drawn += way(f"M330 {y} v{GAP}") + box((12, y + GAP, 636), lines)
    row, names = y + GAP + 2 * LINE, ""
    for who, filled in RULES.items():
        drawn += text(22, row := row + LINE, who)
        for name, does in filled.items():
            names += text(38, row := row + LINE, f"`{name}`")
            drawn += text(228, row, does)
    drawn += f'<g id="rules">\n{names}</g>\n'
    y += GAP + height(lines)
    drawn += way(f"M330 {y} v{GAP}") + box((150, y + GAP, 360), RESULT)
    return save("way", "From a claim to a verdict", drawn, y + GAP + height(RESULT))


def pictures() -> dict[str, str]:
    """Return both pictures."""
    return draw_cell() | draw_way()


if __name__ == "__main__":
    for name, drawn in pictures().items():
        (HERE / "_static" / name).write_text(drawn, encoding="utf-8")
