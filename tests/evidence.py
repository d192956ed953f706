"""Tables and evidence on disk as tests look at them and change them."""

import csv
import sqlite3
from contextlib import closing
from pathlib import Path

from facade import all_lanes, write_lanes


def is_class(problem):
    """Return whether the label of a problem stands for a class of equations."""
    return problem.startswith("every-equation")


def rows_of(file):
    """Return the rows of a table as text."""
    with Path(file).open(newline="", encoding="utf-8") as opened:
        return list(csv.DictReader(opened))


def files_in(folder):
    """Return the files of evidence in a folder and below it."""
    return sorted(folder.rglob("*.sqlite"))


def lanes_in(folder):
    """Return file, name and evidence of each lane in a folder and below it."""
    return [(file, name, lane) for file in files_in(folder) for name, lane in all_lanes(file)]


def change_lanes(folder, change):
    """Write what a function makes of each lane."""
    for file, name, lane in lanes_in(folder):
        write_lanes(file, {name: lambda _, lane=lane: change(lane)})


def damage_lanes(file, damage):
    """Write what a function makes of the bytes of each lane."""
    with closing(sqlite3.connect(file)) as rows, rows:
        for name, content in rows.execute("SELECT name, content FROM lanes").fetchall():
            rows.execute("UPDATE lanes SET content = ? WHERE name = ?", (damage(content), name))
