"""Command line interface: parsing, one-line messages for mistakes, and documented exit codes."""
