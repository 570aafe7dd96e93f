"""Analysis: the one object that runs a scene, relation after relation, step after step."""

from __future__ import annotations

import math
import sys
import time
from collections import Counter
from collections.abc import Sequence
from contextlib import ExitStack, nullcontext
from pathlib import Path
from typing import ClassVar

from rbs_core import checkpoint
from rbs_core.contract import Plan, plan
from rbs_core.errors import BadInput, DishonestRelation, NotFinite
from rbs_core.honesty import Watch, blamed, check_finite
from rbs_core.interrupt import Interrupt
from rbs_core.part import Host, Part
from rbs_core.plugins import registry
from rbs_core.relation import Relation
from rbs_core.report import Progress, Report, Row, log
from rbs_core.schedule import Call, schedule, with_feeders
from rbs_core.stability import UNKNOWN_STEP, largest_stable_step
from rbs_core.trigger import Clock, last_step


class Analysis:
    """A scene: relations in the order in which a step executes them.

    Args:
        relations: the list; `append` adds to it.
        dt: time step, s; the default of `run`.
        steps: total number of steps; the default of `run`.
        until: simulated time to reach, s; the default of `run`.
        title: what the progress line shows.

    `Analysis.current()` is the one scene of a script; `with Analysis() as other:` makes another one current for a
    block, so that tests and notebooks do not leak.
    """

    _stack: ClassVar[list[Analysis]] = []

    def __init__(
        self,
        relations: Sequence[Relation] = (),
        *,
        dt: float | None = None,
        steps: int | None = None,
        until: float | None = None,
        title: str = "rbs",
    ) -> None:
        self.relations = list(relations)
        self.dt, self.steps, self.until, self.title = dt, steps, until, title
        self.clock = Clock(dt=math.nan)
        self.plan = Plan()
        self.report: Report | None = None
        self.given: dict[str, str] = {}

    @classmethod
    def current(cls) -> Analysis:
        """The analysis of this script."""
        if not cls._stack:
            cls._stack.append(cls())
        return cls._stack[-1]

    def __enter__(self) -> Analysis:
        Analysis._stack.append(self)
        return self

    def __exit__(self, *_: object) -> None:
        Analysis._stack.remove(self)

    @property
    def relations(self) -> list[Relation]:
        """What a step does, in order; the same relation may stand in several places."""
        return self._relations

    @relations.setter
    def relations(self, relations: Sequence[Relation]) -> None:
        for position, relation in enumerate(relations):
            if not isinstance(relation, Relation):
                raise BadInput(f"relation {position} is {relation!r}, which is no Relation: list relation objects")
        self._relations = with_feeders(relations)

    def append(self, *relations: Relation) -> None:
        """Adds relations at the end of the list."""
        self.relations = [*self._relations, *relations]

    @property
    def parts(self) -> list[Part]:
        """The parts that the relations speak of, in order of first mention."""
        return [host for host in self.hosts if isinstance(host, Part)]

    @property
    def hosts(self) -> list[Host]:
        """The parts, and connections of parts, that the relations speak of, in order of first mention."""
        relations = [r for r in self._relations if not isinstance(r, checkpoint.Checkpoint)]
        return list(dict.fromkeys(host for relation in relations for host in relation.hosts))

    @property
    def unique(self) -> list[Relation]:
        """The relations, each once."""
        return list(dict.fromkeys(self._relations))

    @property
    def nbytes(self) -> int:
        """Bytes of all fields and bonds, and of what the relations keep beside them."""
        return sum(host.nbytes for host in self.hosts) + sum(relation.nbytes for relation in self.unique)

    # -- before the first step --------------------------------------------------------------------------------------

    def prepare(self, *, debug: bool = False) -> Plan:
        """Checks contracts, allocates what they declare, compiles: everything that can fail fails here.

        Raises:
            MissingField, FieldClash, BadLaw, BadInput: see there; nothing has been computed or written then.
        """
        for name, count in Counter(host.name for host in self.hosts).items():
            if count > 1:
                raise BadInput(f"{count} parts (or connections) are called '{name}': give each its own name")
        unique = self.unique
        for relation in unique:
            if relation.outdated:
                raise BadInput(
                    f"{relation.label} was made for other nodes or bonds than part '{relation.part.name}' has now: "
                    "make the relation again after discretize and connect"
                )
        _check_files(unique)
        self.plan = plan(self._relations, registry().providers)
        for relation in unique:
            relation.choose_storage()
        for part, field in self.plan.fields:
            part.raw(field)
        changed = frozenset(self.plan.changed)
        for relation in unique:
            offered = self.plan.offered.intersection(relation.keys("offers"))
            relation.join(frozenset(offered), changed, debug, unique)
            if isinstance(relation, checkpoint.Checkpoint):
                relation.bind(self)
        for relation in unique:
            with blamed(relation) if debug else nullcontext():
                relation.attach()
        return self.plan

    def stable_dt(self) -> float:
        """Largest stable time step of the scene, s: 2 / (largest angular frequency), over all parts and nodes.

        Raises:
            BadInput: if no relation has a say.
        """
        self.prepare()
        limit = largest_stable_step(self._relations)
        if limit is None:
            raise BadInput(UNKNOWN_STEP)
        return limit.dt

    # -- running ----------------------------------------------------------------------------------------------------

    def run(
        self,
        *,
        steps: int | None = None,
        until: float | None = None,
        dt: float | None = None,
        resume: str | Path | None = None,
        force_dt: bool = False,
        progress: bool | None = None,
        debug: bool = False,
    ) -> Report:
        """Runs the scene.

        Args:
            steps: total number of steps; those done before (resumed, or by an earlier `run`) count.
            until: simulated time to reach, s. With both, the earlier end counts.
            dt: time step, s; 0.8 times the stable one if neither this nor the analysis gives it.
            resume: a checkpoint; the run continues from it if the file exists.
            force_dt: take a dt above the stable one all the same.
            progress: False for silence.
            debug: check in every step that relations do what their contracts say (slow).

        Returns:
            Where the time went, and why the run stopped; Ctrl-C finishes the step, writes the checkpoint and returns.

        Raises:
            UnstableStep: if dt is above the stable one.
            BadCheckpoint: if the checkpoint belongs to another scene.
            NotFinite: if NaN or infinity appears in a force (force relations look at theirs in every step) or in
                what is about to be exported or saved; names step, relation, node and position.
            DishonestRelation: with debug, if a relation breaks its contract.
        """
        begin = time.perf_counter()
        self.prepare(debug=debug)
        dt = self._time_step(self._wanted_dt(dt, resume), force_dt)
        if steps is None and until is None:
            steps, until = self.steps, self.until
        last = last_step(steps, until, dt)
        if self.clock.step == 0:
            self.given = checkpoint.given_values(self)
            for relation in self.unique:
                relation.reset()
        if resume is not None:
            checkpoint.load(resume, self, dt)
        self.clock.dt, self.clock.last_step = dt, last
        calls = schedule(self._relations, self.plan.clear, batches=not debug)
        rows = [Row(call.label) for call in calls]
        report = self.report = Report(rows, nbytes=self.nbytes)
        report.storages = {host.name: host.bonds.storage for host in self.hosts if host.connected}
        report.prepare_seconds = time.perf_counter() - begin
        hooks = registry().manager.hook
        first = self.clock.step
        begin = time.perf_counter()
        try:
            hooks.rbs_analysis_started(analysis=self)
            for relation in self.unique:
                relation.begin(self.clock)
            watch = Watch(self._relations) if debug else None
            if first == 0 < last:
                self._first_sums(watch)
            begin = time.perf_counter()
            with Interrupt() as interrupt, Progress(self.title, first, last, progress) as bar:
                while self.clock.step < last and not interrupt.asked:
                    self._step(calls, rows, watch)
                    bar.show(self.clock.step, last)
                if interrupt.asked:
                    report.stopped = "interrupted"
                    self._save_now()
        except BaseException:
            report.stopped = "failed"
            raise
        finally:
            report.seconds = time.perf_counter() - begin
            report.step, report.time = self.clock.step, self.clock.time
            report.steps = self.clock.step - first
            self._finish(report)
        return report

    def _finish(self, report: Report) -> None:
        """Closes every relation, whatever the others raise; an error of the run itself is the one that is shown."""
        failed = sys.exc_info()[1]
        try:
            with ExitStack() as ends:
                ends.callback(registry().manager.hook.rbs_analysis_finished, analysis=self, report=report)
                for relation in reversed(self.unique):
                    relation.starts = frozenset()
                    ends.callback(relation.close)
        except Exception as error:
            if failed is None:
                raise
            log.warning("after the error of the run, closing failed too: %s: %s", type(error).__name__, error)

    def _first_sums(self, watch: Watch | None) -> None:
        """Makes sums that a step takes over from the step before, once for the initial state (the initial forces).

        What writes the fields that they are made from runs in front of them, e.g. the dilatation of the initial state.
        """
        summed = {key for keys in self.plan.clear.values() for key in keys}
        needed = summed.intersection(self.plan.carried)
        chosen = []
        for position, relation in reversed(list(enumerate(self._relations))):
            made = set(relation.keys("writes", "adds"))
            if made & needed and relation.when(self.clock):
                chosen.append((position, relation))
                needed.update(relation.keys("reads"))
        for part, field in summed & needed:
            part.raw(field)[...] = 0
        for position, relation in reversed(chosen):
            self._apply(Call(position, [relation]), watch)

    def _step(self, calls: list[Call], rows: list[Row], watch: Watch | None) -> None:
        clock = self.clock
        clock.advance()
        for call, row in zip(calls, rows, strict=True):
            for array in call.cleared:
                array.fill(0)
            if not call.due(clock):
                continue
            start = time.perf_counter()
            self._apply(call, watch)
            row.seconds += time.perf_counter() - start
            row.calls += 1
            row.items += call.items()
            row.visited += call.visited()

    def _apply(self, call: Call, watch: Watch | None = None) -> None:
        clock, relation = self.clock, call.relations[0]
        try:
            if watch is not None:
                watch.before(relation)
            if relation.role == "exporter":
                check_finite(relation.keys("reads"))
            with nullcontext() if watch is None else blamed(relation):
                call.apply(clock)
            if watch is not None:
                watch.after(relation)
        except (NotFinite, DishonestRelation) as error:
            where = f"step {clock.step} (time {clock.time:.6g} s), relation {call.position} ({call.label})"
            raise type(error)(f"{where}: {error}") from None

    def _wanted_dt(self, dt: float | None, resume: str | Path | None) -> float | None:
        """The step that was asked for: here, by the scene, or by the run that is resumed."""
        if dt is None and self.dt is None and resume is not None and Path(resume).exists():
            return checkpoint.time_step(resume)
        return self.dt if dt is None else dt

    def _time_step(self, dt: float | None, force: bool) -> float:
        limit = None if force and dt is not None else largest_stable_step(self._relations)
        if dt is None:
            if limit is None:
                raise BadInput(UNKNOWN_STEP)
            dt = self.clock.dt if self.clock.step else 0.8 * limit.dt
        if not (math.isfinite(dt) and dt > 0):
            raise BadInput(f"dt={dt} must be positive and finite")
        if self.clock.step and dt != self.clock.dt:
            raise BadInput(f"this analysis has run {self.clock.step} steps of dt={self.clock.dt!r}: dt cannot change")
        if limit is not None and dt > limit.dt and not force:
            raise limit.refusal(dt)
        return float(dt)

    def _save_now(self) -> None:
        for position, relation in enumerate(self._relations):
            if isinstance(relation, checkpoint.Checkpoint):
                self._apply(Call(position, [relation]))

    def __repr__(self) -> str:
        lines = [f"<Analysis, {len(self._relations)} relations, step {self.clock.step}>"]
        lines += [f"  {number} {relation!r}" for number, relation in enumerate(self._relations)]
        return "\n".join(lines)


def _check_files(relations: Sequence[Relation]) -> None:
    """Two relations must not write the same file.

    Raises:
        BadInput: if they would.
    """
    taken: dict[Path, Relation] = {}
    for relation in relations:
        path = getattr(relation, "path", None)
        if not isinstance(path, Path):
            continue
        other = taken.setdefault(path.resolve(), relation)
        if other is not relation and type(other) is type(relation):
            raise BadInput(f"{other.label} and {relation.label} both write {path}: give each its own path")
