"""What all tests share: runs of pytest inside a test."""

pytest_plugins = "pytester"
