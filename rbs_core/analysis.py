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
from rbs_core.errors import BadInput
from rbs_core.held import held, require_fields
from rbs_core.honesty import Watch, blamed
from rbs_core.interrupt import Interrupt
from rbs_core.memory import as_text
from rbs_core.part import Host, Part
from rbs_core.plugins import registry
from rbs_core.relation import Relation
from rbs_core.report import Progress, Report, log
from rbs_core.report.levels import FILE_ONLY, TIMING
from rbs_core.schedule import Call, schedule, with_feeders
from rbs_core.stability import UNKNOWN_STEP, largest_stable_step
from rbs_core.steps import Steps
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
        """The relations, each once; what one of them owns in front of it."""
        return list(dict.fromkeys(each for relation in self._relations for each in relation.household))

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
        require_fields(self.plan.fields)
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
            dt: time step, s; 0.8 times the stable one if neither this nor the analysis gives it. Where nothing bounds
                it and a static solver is there, 1 / steps of the scene: the time is the share of the loads then.
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
        if steps is None and until is None:
            steps, until = self.steps, self.until
        dt = self._time_step(self._wanted_dt(dt, resume), force_dt, steps)
        last = last_step(steps, until, dt)
        if self.clock.step == 0:
            self.given = checkpoint.given_values(self)
            for relation in self.unique:
                relation.reset()
        if resume is not None:
            checkpoint.load(resume, self, dt)
        self.clock.dt, self.clock.last_step = dt, last
        calls = schedule(self._relations, self.plan.clear, batches=not debug)
        doing = Steps(calls, self.clock)
        report = self.report = Report(doing.rows, nbytes=self.nbytes)
        report.storages = {host.name: host.bonds.storage for host in self.hosts if host.connected}
        report.memory = held(self.hosts, self.unique)
        report.prepare_seconds = time.perf_counter() - begin
        self._tell(report, last)
        hooks = registry().manager.hook
        first = self.clock.step
        begin = time.perf_counter()
        try:
            hooks.rbs_analysis_started(analysis=self)
            for relation in self.unique:
                relation.begin(self.clock)
            doing.watch = Watch(self._relations) if debug else None
            if first == 0 < last:
                doing.first_sums(self._relations, self.plan)
            begin = time.perf_counter()
            needs = Progress(self.title, first, last, progress, nbytes=report.nbytes, size=self._size())
            with Interrupt() as interrupt, needs as bar:
                while self.clock.step < self.clock.last_step and not interrupt.asked:
                    doing.do()
                    bar.show(self.clock.step, last)
                if interrupt.asked:
                    report.stopped = "interrupted"
                    self._save_now(doing)
        except BaseException:
            report.stopped = "failed"
            raise
        finally:
            report.seconds = time.perf_counter() - begin
            report.step, report.time = self.clock.step, self.clock.time
            report.steps = self.clock.step - first
            self._finish(report)
            log.log(TIMING, "%s\n%s", report, report.memory_table(), extra=FILE_ONLY)
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

    def _wanted_dt(self, dt: float | None, resume: str | Path | None) -> float | None:
        """The step that was asked for: here, by the scene, or by the run that is resumed."""
        if dt is None and self.dt is None and resume is not None and Path(resume).exists():
            return checkpoint.time_step(resume)
        return self.dt if dt is None else dt

    def _time_step(self, dt: float | None, force: bool, steps: int | None) -> float:
        limit = None if force and dt is not None else largest_stable_step(self._relations)
        if dt is None and self.clock.step:
            dt = self.clock.dt
        planned = self.steps or steps
        if dt is None and limit is None and any(each.role == "statics" for each in self._relations):
            if not planned:
                raise BadInput(
                    "say how many load steps: steps=..., where the time goes from 0 to 1 and is the share of loads; or "
                    "give dt"
                )
            dt = 1.0 / planned
        if dt is None:
            if limit is None:
                raise BadInput(UNKNOWN_STEP)
            dt = 0.8 * limit.dt
        if not (math.isfinite(dt) and dt > 0):
            raise BadInput(f"dt={dt} must be positive and finite")
        if self.clock.step and dt != self.clock.dt:
            raise BadInput(f"this analysis has run {self.clock.step} steps of dt={self.clock.dt!r}: dt cannot change")
        if limit is not None and dt > limit.dt and not force:
            raise limit.refusal(dt)
        return float(dt)

    def _save_now(self, steps: Steps) -> None:
        for position, relation in enumerate(self._relations):
            if isinstance(relation, checkpoint.Checkpoint):
                steps.apply(Call(position, [relation]))

    def _size(self) -> str:
        """What makes the scene large, in words."""
        bonds = sum(len(host.bonds) for host in self.hosts if host.connected)
        return f"{sum(len(part) for part in self.parts):,} nodes, {bonds:,} directed bonds"

    def _tell(self, report: Report, last: int) -> None:
        """Says into files what run begins, and for debugging what is held."""
        log.info(
            "%s: from step %d to %d, dt %.6g s, %s, %s",
            self.title, self.clock.step, last, self.clock.dt, self._size(), as_text(report.nbytes),
            extra=FILE_ONLY,
        )  # fmt: skip
        log.debug("%s\n%s", self.plan, report.memory_table())

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
