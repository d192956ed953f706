% Euler's scheme in Octave, which answers as the golden transcript does.
1;
function new = euler (given, ask)
  at = struct ("t", given.t, "x", given.x);
  f = ask ("drift", at);
  B = ask ("diffusion", at);
  new.x = given.x + given.h * f;
  for j = 1:columns (given.dW)
    for i = 1:columns (given.x)
      new.x(:, i) += B(:, j, i) .* given.dW(:, j);
    end
  end
end
sdaeverify ("name golden-euler\nform SDE\nnoise dW\nasks drift diffusion\n", @euler);
