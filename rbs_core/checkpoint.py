"""Checkpoint: a relation that saves what a run needs to go on to the bit, and nothing more.

What that is follows from the contracts (`Plan.carried`). The file also holds a fingerprint of the scene; a checkpoint
of another scene is refused with the difference named.
"""

from __future__ import annotations

import functools
import hashlib
import json
import os
import re
import types
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from rbs_core.errors import BadCheckpoint, BadInput
from rbs_core.fields import intact
from rbs_core.files import writable_folder, written_whole
from rbs_core.geometry import Everywhere
from rbs_core.honesty import check_finite
from rbs_core.part import Part
from rbs_core.relation import Key, Relation
from rbs_core.trigger import Clock, Trigger, always

if TYPE_CHECKING:
    from rbs_core.analysis import Analysis

FORMAT = 1
# Globals of a function that belong to what it computes; modules and classes do not.
_PLAIN = (bool, int, float, complex, str, list, tuple, np.generic, np.ndarray, types.FunctionType)


class Checkpoint(Relation):
    """Saves the analysis; stands at the end of the list, so that *when* and *after what* are visible.

    Args:
        path: an .npz file; replaced atomically each time.
        when: trigger, e.g. every(500) or realtime(600).

    Raises:
        BadInput: at the start of the run, if the folder cannot be written.
    """

    role = "checkpoint"
    stays = True
    example = None

    def __init__(self, path: str | Path, *, when: Trigger = always) -> None:
        super().__init__(Part("scene", Everywhere(), dimension=3), when=when)
        self.path = Path(path)
        self._analysis: Analysis | None = None

    def bind(self, analysis: Analysis) -> None:
        """Called by the analysis that it will save.

        Raises:
            BadInput: if relations of another kind stand behind it: a resumed run would leave out the rest of a step.
        """
        place = analysis.relations.index(self)
        behind = [relation for relation in analysis.relations[place:] if not isinstance(relation, Checkpoint)]
        if behind:
            raise BadInput(
                f"relation {place} (Checkpoint) stands before {behind[0].label}: it saves the state between two steps, "
                "so put it at the end of the list"
            )
        self._analysis = analysis

    def attach(self) -> None:
        writable_folder(self.path.parent)

    def apply(self, clock: Clock) -> None:
        if self._analysis is not None:
            check_finite(self._analysis.plan.carried)
            save(self.path, self._analysis)

    @property
    def label(self) -> str:
        return "Checkpoint"


def save(path: Path, analysis: Analysis) -> None:
    """Writes a checkpoint: to a temporary name first, then renamed, so that a crash leaves the old one whole."""
    arrays: dict[str, Any] = {}
    for host, field in _carried(analysis):
        arrays[f"field/{host.name}/{field.name}"] = host.raw(field)
    states: dict[str, Any] = {}
    for key, relation in _keyed(analysis):
        state = relation.state()
        if state:
            states[key] = {}
        for name, value in state.items():
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
        "arrays": sorted(arrays),
        "fingerprint": fingerprint(analysis, clock.dt),
    }
    with written_whole(Path(path)) as partial, partial.open("wb") as file:
        np.savez(file, meta=np.array(json.dumps(meta)), **arrays)
        file.flush()
        os.fsync(file.fileno())


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
    meta, arrays = _read(path)
    difference = _difference(meta["fingerprint"], fingerprint(analysis, dt))
    wanted = {f"field/{part.name}/{field.name}": (part, field) for part, field in _carried(analysis)}
    found = {name: array.shape for name, array in arrays.items() if name.startswith("field/")}
    missed = found.items() ^ {(name, part.raw(field).shape) for name, (part, field) in wanted.items()}
    if difference is None and missed:
        difference = f"carried fields {sorted({name for name, _ in missed})}"
    if difference is not None:
        raise BadCheckpoint(
            f"{path} belongs to another scene, which differs in {difference}: delete the file, or run the scene that "
            "made it"
        )
    for name, (part, field) in wanted.items():
        part.raw(field)[...] = arrays[name]
    for key, relation in _keyed(analysis):
        if key in meta["states"]:
            prefix = f"state/{key}/"
            kept = {name[len(prefix) :]: a for name, a in arrays.items() if name.startswith(prefix)}
            relation.restore({**meta["states"][key], **kept})
    analysis.clock.step = int(meta["step"])
    analysis.clock.dt = dt
    analysis.clock.time = analysis.clock.step * dt
    return True


def _carried(analysis: Analysis) -> list[Key]:
    """The carried fields, but for those of bonds that are searched again: who searches keeps them."""
    return [(host, field) for host, field in analysis.plan.carried if not host.searched_again]


def time_step(path: str | Path) -> float:
    """The time step of a saved run, s."""
    return float.fromhex(_read(Path(path))[0]["dt"])


def _read(path: Path) -> tuple[dict[str, Any], dict[str, NDArray[Any]]]:
    """What a file says, and its arrays.

    Raises:
        BadCheckpoint: if it cannot be read, or not all of it is there.
    """
    try:
        with path.open("rb") as file, np.load(file, allow_pickle=False) as archive:
            arrays = {name: archive[name] for name in archive.files}
        meta = json.loads(str(arrays.pop("meta")))
        version, whole = meta["format"], meta["format"] != FORMAT or sorted(arrays) == meta["arrays"]
    except Exception as error:  # numpy, zipfile and json raise a dozen kinds on damaged files
        raise BadCheckpoint(
            f"{path} is damaged or no checkpoint ({error or type(error).__name__}): delete it and start again"
        ) from None
    if version != FORMAT:
        raise BadCheckpoint(f"{path} has format {version}, this version reads {FORMAT}: delete it and start again")
    if not whole:
        raise BadCheckpoint(f"{path} is damaged (arrays are missing): delete it and start again")
    return meta, arrays


def _keyed(analysis: Analysis) -> list[tuple[str, Relation]]:
    """The relations, each with a key that the resumed scene gives it too."""
    counts: dict[str, int] = {}
    keyed = []
    for relation in analysis.unique:
        number = counts[relation.label] = counts.get(relation.label, -1) + 1
        keyed.append((f"{relation.label}#{number}", relation))
    return keyed


def fingerprint(analysis: Analysis, dt: float) -> dict[str, str]:
    """What makes a scene the same scene: physics, nodes, bonds and given fields. Measures do not count."""
    print_: dict[str, str] = {"time step": f"{dt!r} s"}
    for host in analysis.hosts:
        if host.searched_again or not (host.fields or host.connected):
            continue
        print_[f"nodes of '{host.name}'"] = f"{len(host)}{' in single precision' if host.precision == 'single' else ''}"
        if host.connected:
            print_[f"bonds of '{host.name}'"] = f"{host.bonds.storage} {_digest(*host.bonds.stored.arrays())}"
    physics = _physics(analysis)
    for number, relation in enumerate(physics):
        parameters = ", ".join(f"{name}={_describe(value)}" for name, value in relation.identity().items())
        print_[f"relation {number}"] = f"{relation.label}({parameters})"
    print_["number of relations"] = str(len(physics))
    return {**print_, **analysis.given}


def _physics(analysis: Analysis) -> list[Relation]:
    """The relations that decide what happens: all but exporters, checkpoints, and measures that only those look at."""
    listed = [each for relation in analysis.relations for each in relation.household]
    candidates = [r for r in listed if r.role not in ("exporter", "checkpoint")]
    physics = [r for r in candidates if r.role != "measure"]
    while True:  # a measure counts as soon as something that counts looks at what it makes
        looked_at = {key for r in physics for key in r.keys("reads", "updates")}
        outside = [r for r in candidates if r not in physics]
        more = [r for r in outside if looked_at & set(r.keys("writes", "updates", "adds", "offers"))]
        if not more:
            return [r for r in candidates if r in physics]
        physics += more


def given_values(analysis: Analysis) -> dict[str, str]:
    """Digests of what the script has set, fields and cut bonds: to be taken before the first step changes them."""
    print_: dict[str, str] = {}
    for host in analysis.hosts:
        for field in sorted(host.fields, key=lambda f: f.name):
            if field in host.store(field.at).given:
                print_[f"field '{field.name}' of '{host.name}'"] = _digest(host.raw(field))
        if host.connected and host.bonds.has_broken and not host.searched_again:
            print_[f"broken bonds of '{host.name}'"] = _digest(host.bonds.fields.raw(intact))
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


def _describe(value: Any, outer: tuple[Any, ...] = ()) -> str:
    """A text that is the same in every process, and another one for a function that computes something else."""
    if any(value is each for each in outer):
        return "itself"
    inner = (*outer, value)
    value = getattr(value, "py_func", value)  # what a jitted function was made from
    if isinstance(value, np.ndarray):
        return _digest(value)
    if isinstance(value, types.MethodType):
        return _describe((value.__func__, value.__self__), inner)
    if isinstance(value, functools.partial):
        return _describe((value.func, value.args, value.keywords), inner)
    if isinstance(value, types.FunctionType):
        names = _names(value.__code__)
        numbers = [value.__globals__[n] for n in names if isinstance(value.__globals__.get(n), _PLAIN)]
        defaults = (value.__defaults__, value.__kwdefaults__)
        cells = [cell.cell_contents for cell in value.__closure__ or ()]
        text = _describe((value.__code__, defaults, numbers, cells), inner)
        return f"{value.__qualname__}:{_digest(np.frombuffer(text.encode(), np.uint8))}"
    if isinstance(value, types.CodeType):
        return _describe((np.frombuffer(value.co_code, np.uint8), value.co_names, value.co_consts), inner)
    if isinstance(value, Relation):
        return value.label
    if isinstance(value, list | tuple):
        return "(" + ", ".join(_describe(item, inner) for item in value) + ")"
    if isinstance(value, set | frozenset):
        return "{" + ", ".join(sorted(_describe(item, inner) for item in value)) + "}"
    if isinstance(value, dict):
        return "{" + ", ".join(f"{key!r}: {_describe(item, inner)}" for key, item in value.items()) + "}"
    text = repr(value)
    plain = re.sub(r" at 0x[0-9a-f]+", "", text)
    # an object without a repr of its own is what it holds
    return plain if plain == text or not hasattr(value, "__dict__") else f"{plain}{_describe(vars(value), inner)}"


def _names(code: types.CodeType) -> list[str]:
    """Names that a function and the functions inside of it take from outside."""
    inner = [name for each in code.co_consts if isinstance(each, types.CodeType) for name in _names(each)]
    return list(dict.fromkeys([*code.co_names, *inner]))
