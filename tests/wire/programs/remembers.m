% A program with memory: the state stays where it is, and the memory is the time since it was entered.
1;
function new = enter (given, ask)
  new = struct ("x", given.x, "memory", zeros (rows (given.x), 1));
end
function new = step (given, ask)
  new = struct ("x", given.x, "memory", given.memory + given.h);
end
sdaeverify ("name remembers\nform SDE\nmemory 1\n", @step, @enter);
