"""Results and paths as xarray datasets."""

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
ROW, STEP, POINT = "row", "h", "point"


def dataset(
    variables: Mapping[str, Any],
    coordinates: Mapping[str, Any],
    about: Mapping[str, Any],
    rows: pd.MultiIndex | None = None,
) -> "xarray.Dataset":
    """Create a dataset.

    Parameters
    ----------
    variables, coordinates : mapping of str to tuple
        Dimensions and values by name.
    about : mapping of str to object
        Attributes of the dataset.
    rows : MultiIndex, optional
        Coordinates of the dimension ``row``.

    Raises
    ------
    UsageError
        If xarray is not installed.
    """
    try:
        import xarray  # noqa: PLC0415 - only datasets need it
    except ImportError as error:
        raise UsageError(MISSING) from error
    found = xarray.Dataset(dict(variables), dict(coordinates), dict(about))
    return found if rows is None else found.assign_coords(xarray.Coordinates.from_pandas_multiindex(rows, ROW))


def dataset_of_levels(verdicts: pd.DataFrame, levels: pd.DataFrame) -> "xarray.Dataset":
    """Return verdicts by row, and levels by row, step size and, if there are several, point.

    Parameters
    ----------
    verdicts, levels : DataFrame
        Tables of a result.
    """
    names = list(NAMES)
    keys = verdicts[names].astype(object)
    place = verdicts[names].assign(**{ROW: np.arange(len(verdicts))}).drop_duplicates(names)
    found = levels[levels[STEP].notna()].merge(place, on=names, how="inner")
    sizes, at = np.unique(found[STEP].to_numpy(dtype=float), return_inverse=True)
    points = found.groupby([ROW, STEP]).cumcount().to_numpy()
    several = bool(points.any())
    where = (found[ROW].to_numpy(), at, *([points] if several else []))
    shape = (len(verdicts), len(sizes), *([int(points.max()) + 1] if several else []))
    dimensions = (ROW, STEP, POINT)[: len(shape)]
    columns = {str(name): found[name] for name in levels.columns if name not in {*names, STEP}}
    own = {str(name): (ROW, _values(column)) for name, column in verdicts.items() if name not in names}
    further = {
        f"level_{name}" * (name in own) or name: (dimensions, _scatter(column, where, shape))
        for name, column in columns.items()
    }
    return dataset({**own, **further}, {STEP: sizes}, {}, pd.MultiIndex.from_frame(keys))


def _scatter(column: "pd.Series[Any]", where: tuple[Array, ...], shape: tuple[int, ...]) -> Any:
    values = _values(column)
    table: Any = np.full(shape, np.nan if values.dtype == float else None, dtype=values.dtype)
    table[where] = values
    return table


def _values(column: "pd.Series[Any]") -> Any:
    if pd.api.types.is_numeric_dtype(column) and not pd.api.types.is_bool_dtype(column):
        return column.to_numpy(dtype=float, na_value=np.nan)
    return column.astype(object).where(column.notna(), None).to_numpy()
