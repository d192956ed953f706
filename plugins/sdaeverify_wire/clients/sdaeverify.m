function sdaeverify (hello, step, enter)
  % A solver in Octave for sdaeverify, by version 1 of its wire. Copy this file; it needs no package.
  %
  % On the wire the last axis, of paths, is the fastest; in Octave the first is. So arrays have paths first here: the
  % state x of shape d x P on the wire is a matrix of size P x d, and a diffusion of shape d x l x P one of P x l x d.
  % step (given, ask) returns a struct of arrays, the new state; ask (name, arguments) returns what is asked for:
  %
  %   sdaeverify (["name my-euler\nform SDE\nnoise dW\nneeds scalar-noise\nasks drift diffusion\n"], @euler);
  %   function new = euler (given, ask)
  %     at = struct ("t", given.t, "x", given.x);
  %     f = ask ("drift", at);  B = ask ("diffusion", at);
  %     new.x = given.x + given.h * f + permute (B(:, 1, :), [1, 3, 2]) .* given.dW;
  %   end
  %
  % With "memory" in the hello, enter (given, ask) returns the state that it is given, and the memory to begin with.
  ask = @ask_back;
  while (true)
    [word, given] = read_message ();
    if (isempty (word))
      return;
    elseif (strcmp (word, "hello"))
      fwrite (stdout, hello);
      write_message ("hello", struct ("version", 1));
    elseif (strcmp (word, "enter"))
      write_message ("done", enter (given, ask));
    else
      write_message ("done", step (given, ask));
    end
  end
end

function answer = ask_back (name, arguments)
  write_message (["ask " name], arguments);
  [~, given] = read_message ();
  answer = given.(name);
end

function [word, arrays] = read_message ()
  arrays = struct ();
  line = fgetl (stdin);
  if (! ischar (line))
    word = "";
    return;
  end
  words = strsplit (strtrim (line), " ");
  word = words{1};
  for k = 2:numel (words)
    parts = strsplit (words{k}, "=");
    shape = fliplr (str2double (strsplit (parts{2}, "x")));
    numbers = fread (stdin, prod (shape), "double", 0, "ieee-le");
    arrays.(parts{1}) = reshape (numbers, [shape, 1]);
  end
end

function write_message (words, arrays)
  % A number is of rank 1 on the wire, a matrix of rank 2; a column of P paths is the matrix 1 x P.
  names = fieldnames (arrays);
  line = words;
  for k = 1:numel (names)
    shape = fliplr (size (arrays.(names{k})));
    if (any (strcmp (names{k}, {"t", "version", "failed", "truncated"})) || strncmp (names{k}, "cost.", 5))
      shape = numel (arrays.(names{k}));
    end
    line = [line " " names{k} "=" strjoin(arrayfun (@(n) sprintf ("%d", n), shape, "UniformOutput", false), "x")];
  end
  fwrite (stdout, [line "\n"]);
  for k = 1:numel (names)
    fwrite (stdout, arrays.(names{k})(:), "double", 0, "ieee-le");
  end
  fflush (stdout);
end
