"""Distributions of others: test_thirdparty.py installs them; their own tests are not collected from here."""

collect_ignore_glob = ["*"]
