"""Cells that do not apply are grouped by reason, and nothing is lost."""

from hypothesis import given
from hypothesis import strategies as st

from sdaeverify.report.tables.absent import AbsentGroup, group_absent, in_order, ungroup_absent

MEASURES = ("weak", "drift")
LABELS = ("gbm", "ou[horizon=4]", "gbm[mu=1,sigma=2]", 'named["a, b"]')


def cell(scheme: str, problem: str, measure: str, reason: str) -> dict[str, str]:
    """Return a cell that does not apply."""
    return {"scheme": scheme, "problem": problem, "measure": measure, "quantity": "", "reason": reason}


@given(
    st.lists(
        st.builds(
            cell, st.sampled_from("ab"), st.sampled_from(LABELS), st.sampled_from(MEASURES), st.text(max_size=4)
        ),
        unique_by=lambda each: (each["scheme"], each["problem"], each["measure"], each["reason"]),
    )
)
def test_the_file_gives_all_cells_back(cells: list[dict[str, str]]) -> None:
    """Grouping and ungrouping return the same cells, whatever the labels and reasons."""
    again = ungroup_absent(group.row for group in group_absent(cells))

    def every(rows: list[dict[str, str]]) -> list[list[str]]:
        return sorted([*row.values()] for row in rows)

    assert every(again) == every(cells)
    assert again == in_order(again)


def test_one_reason_of_all_problems_and_measures_is_one_row() -> None:
    """The number of rows does not grow with the number of problems of a form, nor with that of the measures."""
    cells = [cell("a", problem, measure, "needs an SDE") for problem in LABELS for measure in MEASURES]

    assert group_absent(cells) == [AbsentGroup("a", LABELS, MEASURES, "", "needs an SDE")]
