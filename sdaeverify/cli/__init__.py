"""The command line: words in, one line for each mistake, an exit code with one meaning out."""
