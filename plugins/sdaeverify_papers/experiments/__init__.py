"""Tables and figures of papers shipped with sdaeverify, one a file, to be run again by `reproduce`."""
