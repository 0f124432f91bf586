"""Tables of columns: NumPy arrays, and conversion to Arrow, pandas and Polars."""

from __future__ import annotations

import difflib
import html
import importlib
from collections.abc import Iterator
from typing import TYPE_CHECKING, Any, NoReturn

import numpy as np
from numpy.typing import NDArray

if TYPE_CHECKING:
    import pandas  # type: ignore[import-not-found,import-untyped,unused-ignore]
    import polars  # type: ignore[import-not-found,unused-ignore]
    import pyarrow  # type: ignore[import-not-found,import-untyped,unused-ignore]

    from stiction import _native

_SHOWN_ROWS = 10


def _optional(module: str, method: str) -> Any:
    """Imports an optional package.

    Raises:
        ImportError: It is not installed.
    """
    try:
        return importlib.import_module(module)
    except ImportError as error:
        raise ImportError(f"{method} needs the package {module}: pip install {module}") from error


def cell_text(value: object) -> str:
    """Returns a value of a table as short text; empty where there is none."""
    if value is None:
        return ""
    if isinstance(value, float):
        return "" if np.isnan(value) else f"{value:.6g}"
    return str(value)


def html_table(header: list[str], rows: list[list[str]]) -> str:
    """Returns a table as HTML, with escaped cells."""
    lines = ["<table>", "<tr>" + "".join(f"<th>{html.escape(name)}</th>" for name in header) + "</tr>"]
    lines += ["<tr>" + "".join(f"<td>{html.escape(cell)}</td>" for cell in row) + "</tr>" for row in rows]
    return "\n".join([*lines, "</table>"])


class Table:
    """Columns of equal length under their names.

    ``table["name"]`` is a NumPy array, ``len(table)`` the number of rows, iteration gives the names of the columns.
    Arrow readers accept a table as it is (``__arrow_c_stream__``), such as ``polars.DataFrame(table)``.
    """

    def __init__(self, native: _native.Table) -> None:
        self._native = native

    @property
    def columns(self) -> tuple[str, ...]:
        """Names of the columns, in order."""
        return tuple(self._native.column_names)

    def keys(self) -> tuple[str, ...]:
        """Names of the columns, so that ``dict(table)`` has all arrays."""
        return self.columns

    def __len__(self) -> int:
        return self._native.rows

    def __iter__(self) -> Iterator[str]:
        return iter(self.columns)

    def __contains__(self, column: object) -> bool:
        return column in self.columns

    def __getitem__(self, column: str) -> NDArray[Any]:
        """Returns a column as a new array of shape (rows,).

        Numbers are float64 or integers, NaN where there is no value; flags are bool; texts are Python objects of type
        str, None where there is no text.

        Raises:
            KeyError: There is no such column.
        """
        if column not in self.columns:
            near = difflib.get_close_matches(str(column), self.columns, n=1)
            advice = f"; did you mean {near[0]!r}?" if near else ""
            raise KeyError(f"no column {column!r}{advice}")
        values = self._native.column(column)
        if isinstance(values, np.ndarray):
            return values
        array = np.empty(len(values), dtype=object)
        array[:] = values
        return array

    def __arrow_c_stream__(self, requested_schema: object | None = None) -> object:
        """Exports the table by the Arrow PyCapsule interface, with the types of the file."""
        return self._native.__arrow_c_stream__(requested_schema)

    def to_arrow(self) -> pyarrow.Table:
        """Returns a ``pyarrow.Table``.

        Raises:
            ImportError: pyarrow is not installed.
        """
        table: pyarrow.Table = _optional("pyarrow", "to_arrow()").table(self)
        return table

    def to_polars(self) -> polars.DataFrame:
        """Returns a ``polars.DataFrame``.

        Raises:
            ImportError: Polars is not installed.
        """
        frame: polars.DataFrame = _optional("polars", "to_polars()").DataFrame(self)
        return frame

    def to_pandas(self) -> pandas.DataFrame:
        """Returns a ``pandas.DataFrame`` of the arrays; pyarrow is not needed.

        Raises:
            ImportError: pandas is not installed.
        """
        columns = {name: self[name] for name in self.columns}
        frame: pandas.DataFrame = _optional("pandas", "to_pandas()").DataFrame(columns)
        return frame

    def __reduce__(self) -> NoReturn:
        raise TypeError(f"cannot pickle {type(self).__name__}: pickle to_pandas(), to_arrow() or the arrays instead")

    def __repr__(self) -> str:
        return f"{type(self).__name__}({len(self)} rows, {len(self.columns)} columns)"

    def _shown_columns(self) -> list[str]:
        return list(self.columns[:8])

    def _repr_html_(self) -> str:
        names = self._shown_columns()
        columns = [self[name][:_SHOWN_ROWS].tolist() for name in names]
        rows = [[cell_text(value) for value in row] for row in zip(*columns, strict=True)]
        caption = f"<p>{len(self)} rows, {len(self.columns)} columns</p>"
        return html_table(names, rows) + caption


class Series(Table):
    """Time series of a run: ``series["time_s"]`` and further columns, with units in their names.

    Axes are the world's. Numbers that are absent at an instant are NaN, such as the centre of pressure in flight.
    """


class Summary(Table):
    """The summary of a batch: one row per run, with the columns of ``summary.csv``."""

    @property
    def parameters(self) -> tuple[str, ...]:
        """Names of the columns of swept parameters."""
        names = self.columns
        if "seed" not in names or "duration_s" not in names:
            return ()
        return names[names.index("seed") + 1 : names.index("duration_s")]

    def _shown_columns(self) -> list[str]:
        wanted = ["scenario", *self.parameters, "outcome", "message", "steps", "cpu_s", *self._errors()]
        return [name for name in wanted if name in self.columns]

    def _errors(self) -> list[str]:
        """Error columns with values."""
        names = [name for name in self.columns if name.startswith("error_")]
        return [name for name in names if not np.all(np.isnan(self[name].astype(float)))]
