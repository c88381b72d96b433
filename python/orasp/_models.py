"""Problems from CAD models."""

from __future__ import annotations

import os
from collections.abc import Iterable, Mapping
from pathlib import Path
from typing import Any, Optional, Union

from orasp import _orasp
from orasp._content import real, whole
from orasp._problem import Problem
from orasp._solve import ProgressCallback, Stopper, run_of

_MILLIMETRES = {"um": 1e-3, "mm": 1.0, "cm": 10.0, "dm": 100.0, "m": 1000.0, "inch": 25.4, "in": 25.4, "foot": 304.8}
_KINDS = ("contact", "fit", "fastener")


class ImportedModel:
    """A CAD model as a problem, with what was found, assumed and is to be answered.

    ``parts`` are dicts: id, name, mass (kg), density (kg/m^3), material, volume (m^3), closed, triangles.
    """

    def __init__(self, assembly: _orasp.ImportedAssembly) -> None:
        self._assembly = assembly
        self.questions: list[str] = assembly.questions
        self.warnings: list[str] = assembly.warnings
        self.parts: list[dict[str, Any]] = assembly.parts

    @property
    def problem(self) -> Problem:
        """The problem, without its shapes, each time a new one. Its parts take single steps off unless told
        otherwise."""
        return Problem.from_json(self.problem_json())

    def problem_json(self) -> str:
        """The problem as ``orasp import -o -`` prints it."""
        return self._assembly.problem_text("")

    def shapes(self) -> bytes:
        """The shapes as a binary glTF file: a node for each part, named by its id, in metres."""
        return self._assembly.shapes()

    def write(self, file: Union[str, os.PathLike[str]]) -> Path:
        """Writes the problem, and the shapes beside it under the same name with the ending .glb: both or
        neither. Returns the file of the shapes; ``orasp.load(file)`` then knows of them."""
        return Path(self._assembly.write(os.fspath(file)))

    def __repr__(self) -> str:
        return f"<orasp.ImportedModel: {len(self.parts)} parts, {len(self.questions)} questions>"


def import_model(
    *models: Union[str, os.PathLike[str]],
    tolerance: Optional[float] = None,
    unit: Optional[str] = None,
    solids: bool = False,
    pose: Optional[Union[str, os.PathLike[str]]] = None,
    density: Optional[Union[float, Mapping[str, float]]] = None,
    exclude: Union[str, Iterable[str]] = (),
    flexible: Union[str, Iterable[str]] = (),
    base: Optional[Union[str, Iterable[str]]] = None,
    directions: str = "axes",
    action: str = "part",
    duration: Optional[Mapping[str, float]] = None,
    threads: Optional[int] = None,
    progress: Optional[ProgressCallback] = None,
    stop: Optional[Stopper] = None,
) -> ImportedModel:
    """Makes a problem of a CAD model: parts with their masses, connections where they touch, and what blocks
    what along which direction. The arguments are the options of ``orasp import``.

    ``models`` are STEP files, mesh files (OBJ, STL, PLY, glTF, 3MF) or folders of mesh files. ``tolerance``
    is in mm; ``unit`` is um, mm, cm, dm, m, inch or foot; ``density`` in kg/m^3, of all that nothing is known
    of, or by part ({"Plate": 7850}); ``exclude``, ``flexible`` and ``base`` name parts (``"none"`` for no
    base); ``directions`` is axes or geometry; ``action`` part or connection; ``duration`` the seconds by kind
    of connection ({"contact": 0, "fit": 5, "fastener": 10}).

    Raises InputError for files that cannot be read, and where OpenCASCADE (STEP) or assimp (meshes) is
    missing; KeyboardInterrupt on Ctrl-C.
    """
    if not models:
        raise _orasp.InputError("models are missing, files or folders")
    if unit is not None and unit not in _MILLIMETRES:
        raise _orasp.InputError(
            f'unit: "{unit}" is not a unit of length; those are um, mm, cm, dm, m, inch and foot'
        )
    if directions not in ("axes", "geometry"):
        raise _orasp.InputError(f'directions: "{directions}" is neither axes nor geometry')
    if action not in ("part", "connection"):
        raise _orasp.InputError(f'action: "{action}" is neither part nor connection')
    durations = [0.0, 5.0, 10.0]
    for kind, seconds in (duration or {}).items():
        if kind not in _KINDS:
            raise _orasp.InputError(f'duration: "{kind}" is no kind of connection; kinds are contact, fit and fastener')
        durations[_KINDS.index(kind)] = real("duration", seconds, "not_negative")
    by_part: list[tuple[str, float]] = []
    others: Optional[float] = None
    if isinstance(density, Mapping):
        by_part = [(part, real("density", value, "positive")) for part, value in density.items()]
    elif density is not None:
        others = real("density", density, "positive")
    return ImportedModel(
        _orasp.import_model(
            models=[os.fspath(model) for model in models],
            poses="" if pose is None else os.fspath(pose),
            tolerance=None if tolerance is None else real("tolerance", tolerance, "positive"),
            millimetres_per_unit=None if unit is None else _MILLIMETRES[unit],
            solids=solids,
            density=others,
            densities=by_part,
            exclude=_parts(exclude),
            flexible=_parts(flexible),
            base="" if base is None else _parts(base),
            more_directions=directions == "geometry",
            by_part=action == "part",
            durations=durations,
            run=run_of(None, None, None if threads is None else whole("threads", threads, 1, 4096), progress, stop),
        )
    )


def _parts(names: Union[str, Iterable[str]]) -> str:
    return names if isinstance(names, str) else ",".join(names)
