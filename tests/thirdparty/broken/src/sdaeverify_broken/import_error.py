"""A plugin whose module cannot be imported."""

raise ImportError("this plugin needs a library that is not there")
