# A program with memory: the state stays where it is, and the memory is the time since it was entered.
source(commandArgs(TRUE)[1])
enter <- function(given, ask) list(x = given$x, memory = matrix(0, nrow(given$x), 1))
step <- function(given, ask) list(x = given$x, memory = given$memory + given$h)
serve("name remembers\nform SDE\nmemory 1\n", step, enter)
