# Euler's scheme in R, which answers as the golden transcript does.
source(commandArgs(TRUE)[1])
serve("name golden-euler\nform SDE\nnoise dW\nasks drift diffusion\n", function(given, ask) {
  at <- list(t = given$t, x = given$x)
  x <- given$x + given$h * ask("drift", at)
  B <- ask("diffusion", at)
  for (j in seq_len(ncol(given$dW))) {
    for (i in seq_len(ncol(x))) x[, i] <- x[, i] + B[, j, i] * given$dW[, j]
  }
  list(x = x)
})
