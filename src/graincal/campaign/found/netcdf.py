"""A result as one NetCDF file: the groups of ArviZ's schema, as xarray and ArviZ open them."""

from __future__ import annotations

import os
from contextlib import suppress
from pathlib import Path
from typing import TYPE_CHECKING, Any

from graincal.campaign.found.arviz_groups import Group, Groups, groups
from graincal.campaign.stored.trouble import FolderError
from graincal.data import InputError
from graincal.errors import not_installed

if TYPE_CHECKING:
    from graincal.campaign.found.emulated import Emulated
    from graincal.campaign.found.record import Record

FILE = "posterior.nc"

_DRAWN = ("posterior", "prior", "sample_stats", "posterior_predictive")
"""The groups whose arrays begin with chain and draw."""


def export_netcdf(result: Record, emulated: Emulated | None, folder: Path, *, replace: bool = False) -> list[Path]:
    """Write posterior.nc and return its path. Parameters have their unit and range as attributes.

    Raises InputError where xarray or h5netcdf is not installed, where there is no posterior, and for a file that is there already, unless it is to be replaced.
    """
    try:
        import h5netcdf  # noqa: F401
        import xarray
    except ImportError as error:
        raise not_installed("export --to netcdf", "xarray and h5netcdf", "netcdf", error) from None
    path = folder / FILE
    if path.exists() and not replace:
        raise InputError(f"{path}: this file is there already and is not overwritten; name another folder.")
    found = groups(result, emulated)
    tree = xarray.DataTree.from_dict({name: _dataset(xarray, result, found, name, group) for name, group in found.data.items()})
    tree.attrs.update(inference_library="graincal", inference_library_version=result.provenance["graincal"], created_at=result.started)
    unfinished = path.with_name(f".{path.name}.part")
    try:
        folder.mkdir(parents=True, exist_ok=True)
        tree.to_netcdf(unfinished, engine="h5netcdf")
        os.replace(unfinished, path)
    except OSError as error:
        with suppress(OSError):
            unfinished.unlink(missing_ok=True)
        raise FolderError.of(path, error) from error
    return [path]


def _dataset(xarray: Any, result: Record, found: Groups, name: str, group: Group) -> Any:
    before = ("chain", "draw") if name in _DRAWN else ()
    variables = {}
    coords: dict[str, Any] = {}
    for key, array in group.items():
        along = found.dims.get(key, [])
        dims = (*before, *map(_named, along))
        variables[_named(key)] = (dims, array, _attributes(result, key) if name in ("posterior", "prior") else {})
        coords |= {_named(each): found.coords[each] for each in along}
        coords |= {each: range(size) for each, size in zip(before, array.shape)}
    return xarray.Dataset(variables, coords)


def _attributes(result: Record, name: str) -> dict[str, Any]:
    space = result.space
    k = space.names.index(name)
    return {"range": [float(space.low[k]), float(space.high[k])], "unit": space.units[k] or ""}


def _named(name: str) -> str:
    """In NetCDF a slash stands between groups."""
    return name.replace("/", "_")
