# Euler's scheme for dx = -x dt + 0.7 dW, x(0) = 1, with R's own random numbers and no package.
words <- strsplit(commandArgs(trailingOnly = TRUE), "=", fixed = TRUE)
given <- setNames(as.numeric(sapply(words, `[`, 2)), sapply(words, `[`, 1))
set.seed(given[["seed"]])
h <- given[["h"]]
x <- rep(1, given[["paths"]])
for (step in seq_len(round(given[["T"]] / h))) {
  x <- x - h * x + 0.7 * sqrt(h) * rnorm(length(x))
}
out <- file("/dev/stdout", "wb")
writeBin(x, out, size = 8, endian = "little")
close(out)
