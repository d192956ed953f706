"""Repairs of the mistakes that the kit finds, by the name of the check."""

SCHEME = {
    "declaration": "Write `@dataclass(frozen=True)` above the class, give it `name`, `form` and `claims`, and "
    "each parameter a default that is a bool, an int, a float or a str.",
    "label": "Make each field of the dataclass a parameter with a default. Values computed from it must not "
    "take part in `==`.",
    "pickle": "Keep only parameters in fields. Compute derived values in `prepare(problem, h)` or in a "
    "`cached_property`, which `==` ignores.",
    "frozen": "Write `@dataclass(frozen=True)`, and do not override `__setattr__`.",
    "docstring": "Write the formula of the step as the first line of the class.",
    "source": "Set `source` to the paper and the number of the equation, or to `measured`.",
    "claims": "Correct the name of the measure or the trait: `sdaeverify list measures` and `sdaeverify info "
    "traits` show all.",
    "exact-on-trivial-equations": "Compare the step with the equation term by term: a factor of h or dW is "
    "wrong, or a Brownian motion is left out. If the scheme supports one Brownian motion only, say so in "
    "`refuses`.",
    "inputs-untouched": "Write `state = state + ...`, not `state += ...`; copy an array before you change it.",
    "state-like-its-own": "Return arrays of the shape and type of the given state: keep the last axis, and float64.",
    "any-number-of-paths": "Use no fixed number of paths: index from the front, `state[0]`, and leave the last "
    "axis unchanged.",
    "finite": "Return `Step(state, failed=mask)` for paths on which the step has no solution, and guard divisions.",
    "same-call-same-bits": "Take all randomness from `noise`, keep no counter and no cache in the scheme.",
    "paths-in-any-order": "Do not use the position of a path in the batch, `np.arange(paths)` for example.",
    "paths-alone": "Take no mean, maximum or norm over the last axis; end an iteration for each path separately.",
    "any-number-of-steps": "Let a step depend smoothly on `h`, and not on the number of steps of a run.",
    "declared-noise-only": 'Declare all noise that the step uses: `noise = frozenset({"dW", "H"})`.',
    "equation-alone": "Use the coefficients of the problem, not its source, observables or truths.",
    "noise-is-used": "Use `noise.dW` with its sign. If the law of the noise is your own, set `law`.",
    "own-memory": "Return a new array: `noise.dW.copy()`, or an expression, not a view of the noise.",
    "state-is-whole": "Put all memory into the state, and set it in `enter(problem, state, t, h)`.",
    "claims-tested": "Correct the name of the quantity, or the traits in `when=`, so that some registered "
    "problem has them.",
}
PROBLEM = {
    "declaration": "Give each parameter of the function a default that is a bool, an int, a float or a str.",
    "builds": "Call the function in Python and correct the argument that the message names.",
    "label": "Let the function depend on its parameters alone, not on a global variable that changes.",
    "pickle": "Define the function at the top of its module, not inside another function, and without `lambda`.",
    "docstring": "Write the equation as the first line of the function.",
    "source": "Set `source` of the problem and of each truth, and `units`.",
    "in-matrix": "Correct the parameters, schemes or measures in `@in_matrix(...)`.",
    "relaxation": "Give `relaxation_time` together with an `InvariantMean`, or neither of them.",
    "consistent-start": "Start on the constraint: g(r) = 0, Dg(r) v = 0 and u = 0 to rounding. Compute the "
    "initial values instead of typing rounded ones.",
    "observables": "Return one number for each path: sum over the first axis, keep the last one.",
    "path-by-path": "Take no mean, maximum or norm over the last axis in a coefficient.",
    "finite-in-time": "Look for a division by zero, a root or a logarithm in the coefficient at the named time.",
    "diffusion-product": "Correct `diffusion_product`, or leave it out: it is then the product with the matrix.",
    "diffusion-derivative": "Correct `diffusion_derivative`, or leave it out if the diffusion is analytic (no "
    "`abs`, no `max`, no real buffer).",
    "constraint-jacobian": "Correct the Jacobian, or leave it out if the constraint is analytic (no `abs`, no "
    "`max`, no real buffer).",
    "constraint-curvature": "Correct the curvature, or leave it out if the constraint is analytic.",
    "constraint-second-derivatives": "Correct the second derivatives and their traces, or leave them out.",
    "constraint-linearisation": "Correct `linearisation`: its products must be those with the matrix Dg.",
    "force-derivatives": "Correct `force_derivatives`, or leave it out if the force is analytic.",
    "delay-derivatives": "Correct `partials`, or leave them out if the coefficients are analytic.",
    "algebraic-solution": "Correct `solved`, or iterate further: u must be 0 to rounding.",
    "constraints-kept": "Add Ito's term to the drift, (1/2) sum_j DB_j B_j, if the equation is Stratonovich's; "
    "check that the columns of the diffusion are tangent.",
    "view-equals-form": "Do not override the conversion of the form to an SDE, or correct the override.",
    "traits": "Remove the trait, or correct the coefficient that contradicts it.",
    "chart": "Let `read` be the inverse of `embed`, and choose limits that include the initial state.",
    "moments-start": "At time 0, let the moment return the observable at the initial state.",
    "moments-rate": "Derive the moment again by Ito's formula; the sign or the factor 1/2 of the noise is the "
    "usual mistake.",
    "moments-settle": "One of moment, invariant mean and relaxation time is wrong: compare the limits by hand.",
    "moments-simulated": "The moment belongs to another equation: compare its parameters, and Ito with Stratonovich.",
    "solution-start": "Let `parts` return the names of the problem's components, with the values of the start "
    "at time 0.",
    "solution-step": "Return a new array of the same shape from `advance`; write nothing into its arguments.",
    "solution-still": "With h = 0 and zero noise, `advance` must return its input: look for a term without h or dW.",
    "solution-simulated": "The solution belongs to another equation: compare its parameters, and Ito with "
    "Stratonovich.",
    "solution-averaged": "Solution or moment is wrong. The check `moments-simulated` says whether it is the moment.",
    "controls": "Choose a positive control that has the order on this problem, and a negative control that does not "
    "have it: run both with `matrix -p PROBLEM` first.",
}
REPAIRS = {"scheme": SCHEME, "problem": PROBLEM}
