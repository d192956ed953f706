"""Arrays of another library behind NumPy's protocols, so that formulas written with NumPy run on them unchanged.

A formula that bypasses NumPy's functions (``float(x)``, ``if x > 0``, assignment into a buffer, ``np.asarray``)
cannot be run this way, and raises.
"""

from collections.abc import Callable, Iterator, Mapping
from typing import Any

import numpy as np
from numpy.lib.mixins import NDArrayOperatorsMixin

from sdaeverify.errors import FAULTS, one_line

# A module, or an object like one, whose functions have the names and arguments of NumPy's.
Namespace = Any
# PyTorch's names of functions where they differ from NumPy's.
ALIASES = {"absolute": "abs", "concatenate": "cat", "conjugate": "conj", "power": "pow", "invert": "bitwise_not"}
# Functions of PyTorch that require factors of one type.
PRODUCTS = frozenset({"einsum", "matmul"})


class Foreign(NDArrayOperatorsMixin):
    """An array of another library that behaves as a NumPy array in formulas.

    Parameters
    ----------
    array : object
        Array of the library.
    namespace : module
        Functions of the library under NumPy's names, for example ``jax.numpy``, possibly with ``linalg``.
    """

    def __init__(self, array: Any, namespace: Namespace) -> None:
        self.array, self.namespace = array, namespace

    def __array_ufunc__(self, ufunc: np.ufunc, method: str, *inputs: Any, **given: Any) -> Any:
        """Call the library's function of the same name."""
        if method != "__call__" or given:
            # This includes assignment into an array, because x += y passes out=x.
            return NotImplemented
        return self._call(self.namespace, ufunc.__name__, inputs, {})

    def __array_function__(self, function: Callable[..., Any], _: Any, args: Any, given: Any) -> Any:
        """Call the library's function of the same name."""
        home = function.__module__.removeprefix("numpy").removeprefix(".")
        space = getattr(self.namespace, home, None) if home else self.namespace
        return self._call(space, function.__name__, args, given)

    def __array__(self, *_: Any, **__: Any) -> Any:
        """Raise, because the library could not trace operations on a NumPy array."""
        raise TypeError("makes a NumPy array of a state")

    def __bool__(self) -> bool:
        raise TypeError("branches on the value of a state")

    def __len__(self) -> int:
        return int(self.shape[0])

    def __iter__(self) -> Iterator[Any]:
        return (self[index] for index in range(len(self)))

    def __getitem__(self, key: Any) -> Any:
        return self._wrap(self.array[_bare(key)])

    def __getattr__(self, name: str) -> Any:
        if name.startswith("__"):
            raise AttributeError(name)
        value = getattr(self.array, name)
        if not callable(value):
            return self._wrap(value) if name in {"T", "real", "imag"} else value
        return lambda *args, **given: self._wrap(value(*_bare(args), **_bare(given)))

    def _call(self, space: Namespace, name: str, args: Any, given: Any) -> Any:
        function = getattr(space, name, None)
        if function is None:
            raise TypeError(f"uses {name}, which the library has not")
        return self._wrap(function(*_bare(args), **_bare(given)))

    def _wrap(self, value: Any) -> Any:
        if isinstance(value, tuple | list):
            return type(value)(self._wrap(item) for item in value)
        return Foreign(value, self.namespace)


def _bare(value: Any) -> Any:
    """Unwrap `Foreign` arrays in arguments."""
    if isinstance(value, Foreign):
        return value.array
    if isinstance(value, dict):
        return {name: _bare(item) for name, item in value.items()}
    if type(value) in (tuple, list):
        return type(value)(_bare(item) for item in value)
    return value


class TorchFunctions:
    """Functions of PyTorch that also accept NumPy arrays, in double precision.

    Parameters
    ----------
    torch : module
        The module of PyTorch, which is not imported here.
    within : module, optional
        Submodule of PyTorch that provides the functions; by default PyTorch itself.
    """

    def __init__(self, torch: Any, within: Any = None) -> None:
        self.torch, self.module = torch, within or torch

    @property
    def linalg(self) -> "TorchFunctions":
        """Functions of linear algebra."""
        return TorchFunctions(self.torch, self.torch.linalg)

    def __getattr__(self, name: str) -> Callable[..., Any]:
        function = getattr(self.module, ALIASES.get(name, name))
        # PyTorch's elementwise functions require tensors where NumPy's also accept numbers.
        numbers = isinstance(getattr(np, name, None), np.ufunc)

        def call(*args: Any, **given: Any) -> Any:
            tensors = [self._tensor(value, numbers=numbers) for value in args]
            return function(*(self._of_one_type(tensors) if name in PRODUCTS else tensors), **given)

        return call

    def asarray(self, value: Any) -> Any:
        """Convert to a tensor in double precision."""
        return self.torch.tensor(np.asarray(value, dtype=float))

    def _of_one_type(self, values: list[Any]) -> list[Any]:
        """Convert all factors to complex tensors if one of them is complex."""
        if not any(self.torch.is_tensor(value) and value.is_complex() for value in values):
            return values
        return [value.to(self.torch.complex128) if self.torch.is_tensor(value) else value for value in values]

    def _tensor(self, value: Any, *, numbers: bool) -> Any:
        """Convert NumPy arrays and, on request, numbers in arguments to tensors."""
        if isinstance(value, np.ndarray) or (numbers and isinstance(value, int | float | complex | np.number)):
            whole = np.asarray(value)
            return self.torch.tensor(whole if np.iscomplexobj(whole) else whole.astype(float))
        return [self._tensor(item, numbers=numbers) for item in value] if type(value) is list else value


def why_not_run(formulas: Mapping[str, Callable[..., Any]], *arguments: Any) -> str:
    """Return which formula cannot be run on `Foreign` arrays, and why, or an empty string.

    Parameters
    ----------
    formulas : mapping of str to callable
        Formulas by name.
    *arguments : object
        NumPy arrays wrapped as `Foreign`, so that no library has to be imported.
    """
    for what, formula in formulas.items():
        try:
            with np.errstate(all="ignore"):
                formula(*arguments)
        except FAULTS as error:
            return f"its {what} runs on NumPy's arrays alone: {one_line(error)}"
    return ""
