# A solver in R for sdaeverify, by version 1 of its wire. Copy this file; it needs base R alone.
#
# On the wire the last axis, of paths, is the fastest; in R the first is. So arrays have paths first here: the state x
# of shape d x P on the wire is a matrix of P rows and d columns, and a diffusion of shape d x l x P an array of
# dimensions P, l, d. One number on the wire is a vector of length 1. step(given, ask) returns a list of arrays, the new
# state; ask(name, arguments) returns a coefficient:
#
#   source("sdaeverify.R")
#   serve("name my-euler\nform SDE\nnoise dW\nneeds scalar-noise\nasks drift diffusion\n", function(given, ask) {
#     at <- list(t = given$t, x = given$x)
#     f <- ask("drift", at); B <- ask("diffusion", at)
#     list(x = given$x + given$h * f + B[, 1, ] * as.vector(given$dW))
#   })
#
# With "memory" in the hello, enter(given, ask) returns the state that it is given, and the memory to begin with.

serve <- function(hello, step, enter = NULL) {
  input <- file("stdin", "rb")
  # stdout() of R converts text; a process that copies bytes does not, and also writes to a socket.
  output <- pipe("exec cat", "wb")
  on.exit({ close(output); close(input) })

  read_message <- function() {
    line <- readLines(input, n = 1L)
    if (length(line) == 0L) return(list(word = ""))
    words <- strsplit(trimws(line), " +")[[1L]]
    arrays <- list()
    for (word in words[-1L]) {
      parts <- strsplit(word, "=", fixed = TRUE)[[1L]]
      shape <- rev(as.integer(strsplit(parts[2L], "x", fixed = TRUE)[[1L]]))
      numbers <- readBin(input, "double", prod(shape), size = 8L, endian = "little")
      if (length(shape) > 1L) dim(numbers) <- shape
      arrays[[parts[1L]]] <- numbers
    }
    list(word = words[1L], arrays = arrays)
  }

  write_message <- function(words, arrays) {
    lengths <- lapply(arrays, function(a) rev(if (is.null(dim(a))) length(a) else dim(a)))
    shapes <- vapply(lengths, paste, "", collapse = "x")
    line <- paste(c(words, paste0(names(arrays), "=", shapes)), collapse = " ")
    writeBin(charToRaw(paste0(line, "\n")), output)
    for (numbers in arrays) writeBin(as.double(numbers), output, size = 8L, endian = "little")
    flush(output)
  }

  ask <- function(name, arguments) {
    write_message(paste("ask", name), arguments)
    read_message()$arrays[[name]]
  }

  repeat {
    message <- read_message()
    if (message$word == "") return(invisible())
    if (message$word == "hello") {
      writeBin(charToRaw(hello), output)
      write_message("hello", list(version = 1))
    } else {
      answer <- if (message$word == "enter") enter else step
      write_message("done", answer(message$arrays, ask))
    }
  }
}
