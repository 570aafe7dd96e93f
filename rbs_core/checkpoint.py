"""Checkpoint: a relation that saves what a run needs to go on to the bit, and nothing more.

What that is follows from the contracts (`Plan.carried`). The file also holds a fingerprint of the scene; a checkpoint
of another scene is refused with the difference named.
"""

from __future__ import annotations

import hashlib
import json
import os
import re
import types
import zipfile
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from rbs_core.errors import BadCheckpoint, BadInput
from rbs_core.geometry import Everywhere
from rbs_core.part import Part
from rbs_core.relation import Relation
from rbs_core.trigger import Clock, Trigger, always

if TYPE_CHECKING:
    from rbs_core.analysis import Analysis

FORMAT = 1


class Checkpoint(Relation):
    """Saves the analysis; stands at the end of the list, so that *when* and *after what* are visible.

    Args:
        path: an .npz file; replaced atomically each time.
        when: trigger, e.g. every(500) or realtime(600).

    Raises:
        BadInput: at the start of the run, if the folder cannot be written.
    """

    role = "checkpoint"
    example = None

    def __init__(self, path: str | Path, *, when: Trigger = always) -> None:
        super().__init__(Part("scene", Everywhere(), dimension=3), when=when)
        self.path = Path(path)
        self._analysis: Analysis | None = None

    def bind(self, analysis: Analysis) -> None:
        """Called by the analysis that it will save."""
        self._analysis = analysis

    def attach(self) -> None:
        writable_folder(self.path.parent)

    def apply(self, clock: Clock) -> None:
        if self._analysis is not None:
            save(self.path, self._analysis)

    @property
    def label(self) -> str:
        return "Checkpoint"


def writable_folder(folder: Path) -> Path:
    """Makes a folder and proves that it can be written, before any work is done for it.

    Raises:
        BadInput: if not.
    """
    try:
        folder.mkdir(parents=True, exist_ok=True)
        probe = folder / f".probe-{os.getpid()}"
        probe.touch()
        probe.unlink()
    except OSError as error:
        raise BadInput(f"cannot write into the folder {folder}: {error.strerror or error}: choose another one") from None
    return folder


def save(path: Path, analysis: Analysis) -> None:
    """Writes a checkpoint: to a temporary name first, then renamed, so that a crash leaves the old one whole."""
    arrays: dict[str, Any] = {}
    for part, field in analysis.plan.carried:
        arrays[f"field/{part.name}/{field.name}"] = part[field]
    states: dict[str, Any] = {}
    for key, relation in _with_state(analysis):
        states[key] = {}
        for name, value in relation.state().items():
            if isinstance(value, np.ndarray):
                arrays[f"state/{key}/{name}"] = value
            else:
                states[key][name] = value
    clock = analysis.clock
    meta = {
        "format": FORMAT,
        "step": clock.step,
        "dt": clock.dt.hex(),
        "states": states,
        "fingerprint": fingerprint(analysis, clock.dt),
    }
    path = Path(path)
    partial = path.with_name(f".{path.name}.{os.getpid()}.partial")
    try:
        with partial.open("wb") as file:
            np.savez(file, meta=np.array(json.dumps(meta)), **arrays)
            file.flush()
            os.fsync(file.fileno())
        partial.replace(path)
    finally:
        partial.unlink(missing_ok=True)


def load(path: str | Path, analysis: Analysis, dt: float) -> bool:
    """Takes clock, carried fields and states of relations from a checkpoint, if the file exists.

    Returns:
        True if there was a checkpoint.

    Raises:
        BadCheckpoint: if the file is damaged or belongs to another scene; the analysis is as before then.
    """
    path = Path(path)
    if not path.exists():
        return False
    try:
        with np.load(path, allow_pickle=False) as file:
            arrays = {name: file[name] for name in file.files}
        meta = json.loads(str(arrays.pop("meta")))
        if meta["format"] != FORMAT:
            raise BadCheckpoint(f"{path} has format {meta['format']}, this version reads {FORMAT}: start again")
        difference = _difference(meta["fingerprint"], fingerprint(analysis, dt))
    except (OSError, KeyError, ValueError, TypeError, zipfile.BadZipFile) as error:
        if isinstance(error, BadCheckpoint):
            raise
        raise BadCheckpoint(f"{path} is damaged or no checkpoint ({error}): delete it and start again") from None
    wanted = {f"field/{part.name}/{field.name}": (part, field) for part, field in analysis.plan.carried}
    found = {name for name in arrays if name.startswith("field/")}
    if difference is None and found != set(wanted):
        difference = f"carried fields {sorted(found ^ set(wanted))}"
    if difference is not None:
        raise BadCheckpoint(
            f"{path} belongs to another scene, which differs in {difference}: delete the file, or run the scene that "
            "made it"
        )
    for name, (part, field) in wanted.items():
        part[field][...] = arrays[name]
    for key, relation in _with_state(analysis):
        if key in meta["states"]:
            prefix = f"state/{key}/"
            kept = {name[len(prefix) :]: a for name, a in arrays.items() if name.startswith(prefix)}
            relation.restore({**meta["states"][key], **kept})
    analysis.clock.step = int(meta["step"])
    analysis.clock.dt = dt
    analysis.clock.time = analysis.clock.step * dt
    return True


def _with_state(analysis: Analysis) -> list[tuple[str, Relation]]:
    """The relations that keep something privately, each with a key that the resumed scene gives it too."""
    counts: dict[str, int] = {}
    keyed = []
    for relation in analysis.unique:
        if relation.state():
            number = counts[relation.label] = counts.get(relation.label, -1) + 1
            keyed.append((f"{relation.label}#{number}", relation))
    return keyed


def fingerprint(analysis: Analysis, dt: float) -> dict[str, str]:
    """What makes a scene the same scene: physics, nodes, bonds and given fields. Exporters do not count."""
    print_: dict[str, str] = {"time step": dt.hex()}
    physics = [r for r in analysis.relations if r.role not in ("exporter", "checkpoint")]
    for number, relation in enumerate(physics):
        parameters = ", ".join(f"{name}={_describe(value)}" for name, value in relation.parameters.items())
        print_[f"relation {number}"] = f"{relation.label}({parameters})"
    print_["number of relations"] = str(len(physics))
    for part in analysis.parts:
        if not part.fields:
            continue
        print_[f"nodes of '{part.name}'"] = str(len(part))
        if part.connected:
            print_[f"bonds of '{part.name}'"] = _digest(*part.bonds.as_rows())
        for field in sorted(part.fields, key=lambda f: f.name):
            if (part, field) not in analysis.plan.changed and field in part.store(field.at).given:
                print_[f"field '{field.name}' of '{part.name}'"] = _digest(part[field])
    return print_


def _difference(old: dict[str, str], new: dict[str, str]) -> str | None:
    for key in (*old, *new):
        if old.get(key) != new.get(key):
            return f"{key}: {old.get(key, 'not there')} in the file, {new.get(key, 'not there')} in this scene"
    return None


def _digest(*arrays: Any) -> str:
    digest = hashlib.blake2b(digest_size=12)
    for array in arrays:
        digest.update(np.ascontiguousarray(array).data)
    return digest.hexdigest()


def _describe(value: Any) -> str:
    """A text that is the same in every process."""
    if isinstance(value, np.ndarray):
        return _digest(value)
    if isinstance(value, types.FunctionType):
        code = value.__code__
        return f"{value.__qualname__}:{_digest(np.frombuffer(code.co_code, np.uint8))}:{code.co_consts!r}".split(" at 0x")[0]
    if isinstance(value, Relation):
        return value.label
    if isinstance(value, list | tuple):
        return "(" + ", ".join(_describe(item) for item in value) + ")"
    return re.sub(r" at 0x[0-9a-f]+", "", repr(value))
