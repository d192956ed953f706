"""Tables of a run: columns, conversion of findings to rows, and commands that reproduce a row."""
