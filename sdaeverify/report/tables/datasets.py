"""Results and paths as datasets of xarray, where that is installed."""

from collections.abc import Mapping
from typing import TYPE_CHECKING, Any

import numpy as np
import pandas as pd

from ...arrays import Array
from ...errors import UsageError
from ..folders import NAMES

if TYPE_CHECKING:
    import xarray

MISSING = "to_xarray needs xarray: pip install 'sdaeverify[xarray]'"
ROW, LEVEL = "row", "level"


def dataset(
    variables: Mapping[str, Any], coordinates: Mapping[str, Any], about: Mapping[str, Any]
) -> "xarray.Dataset":
    """Return a dataset.

    Parameters
    ----------
    variables, coordinates : mapping of str to tuple
        By name, dimensions and values.
    about : mapping of str to object
        Its attributes.

    Raises
    ------
    UsageError
        If there is no xarray.
    """
    try:
        import xarray  # noqa: PLC0415 - only datasets need it
    except ImportError as error:
        raise UsageError(MISSING) from error
    return xarray.Dataset(dict(variables), dict(coordinates), dict(about))


def dataset_of_levels(verdicts: pd.DataFrame, levels: pd.DataFrame) -> "xarray.Dataset":
    """Return verdicts, by row, and levels, by row and their number within it.

    Parameters
    ----------
    verdicts, levels : DataFrame
        Tables of a result.
    """
    names = list(NAMES)
    place = verdicts[names].assign(**{ROW: np.arange(len(verdicts))}).drop_duplicates(names)
    found = levels.merge(place, on=names, how="inner")
    at = found[ROW].to_numpy(), found.groupby(ROW).cumcount().to_numpy()
    shape = len(verdicts), int(at[1].max(initial=-1)) + 1
    columns = {str(name): found[name] for name in levels.columns if name not in names}
    own = {str(name): (ROW, column.to_numpy(dtype=_kind(column))) for name, column in verdicts.items()}
    further = {name: ((ROW, LEVEL), _scatter(column, at, shape)) for name, column in columns.items()}
    clashes = {name: f"level_{name}" for name in further if name in own}
    return dataset({**own, **{clashes.get(name, name): each for name, each in further.items()}}, {}, {})


def _scatter(column: "pd.Series[Any]", at: tuple[Array, Array], shape: tuple[int, int]) -> Any:
    kind = _kind(column)
    table: Any = np.full(shape, np.nan if kind is float else None, dtype=kind)
    table[at] = column.astype(float).to_numpy() if kind is float else column.to_numpy(dtype=object)
    return table


def _kind(column: "pd.Series[Any]") -> type:
    return float if pd.api.types.is_numeric_dtype(column) and not pd.api.types.is_bool_dtype(column) else object
