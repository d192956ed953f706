"""The shipped measures: each module is a plugin with one measure."""
