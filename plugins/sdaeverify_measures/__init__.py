"""The measures of papers: each module is a plugin of its own, with the probes that only it uses."""
