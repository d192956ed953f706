"""The checks of the conformance kit, one concern a file."""
