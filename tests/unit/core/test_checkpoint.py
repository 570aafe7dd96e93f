"""A resumed run equals the uninterrupted one to the bit, and nothing else is resumed."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import pytest

import rbs_core as rbs
from rbs_core import Analysis, BadInput, Checkpoint, NotFinite, every
from rbs_plugins import CSVExporter
from rbs_plugins.fields import external_work
from tests.scenes import Scene, block, plate
from tests.unit.core.toys import Toy, a, d, field, held, line, oscillators, plus, refused

# -- equality to the bit --------------------------------------------------------------------------------------------


@pytest.mark.parametrize("stop", [1, 2, 13, 20])
def test_a_resumed_run_equals_the_uninterrupted_one(tmp_path, stop):
    whole, analysis = oscillators(tmp_path / "whole.npz")
    analysis.run(steps=20)
    _, analysis = oscillators(tmp_path / "state.npz")
    analysis.run(steps=stop)
    resumed, analysis = oscillators(tmp_path / "state.npz")
    report = analysis.run(steps=20, resume=tmp_path / "state.npz")
    assert held(resumed) == held(whole)
    assert (report.steps, report.step, report.time) == (20 - stop, 20, 20 * 0.1)
    assert whole[rbs.intact].min() == 0 or stop < 7


def _broken(scene: Scene) -> int:
    return int(np.count_nonzero(~scene.part.bonds.intact))


@pytest.mark.parametrize("energies", [True, False])
def test_a_breaking_plate_resumes_to_the_bit(tmp_path, energies):
    """60 steps in one go, or 30, a checkpoint and 30 more on a new plate; bonds break before and behind the stop."""

    def scene(name):
        return plate(n=40, speed=100.0, s0=0.01, energies=tmp_path / f"{name}.csv" if energies else None)

    whole, first, resumed = scene("whole"), scene("pieces"), scene("pieces")
    whole.analysis(Checkpoint(tmp_path / "whole.npz", when=every(100))).run(steps=60)
    broken = [_broken(first)]
    first.analysis(Checkpoint(tmp_path / "state.npz", when=every(30))).run(steps=30)
    broken.append(_broken(first))
    resumed.analysis(Checkpoint(tmp_path / "state.npz", when=every(30))).run(steps=60, resume=tmp_path / "state.npz")
    broken.append(_broken(resumed))
    assert broken == sorted(set(broken))
    assert held(resumed.part) == held(whole.part)
    if energies:
        assert (tmp_path / "pieces.csv").read_bytes() == (tmp_path / "whole.csv").read_bytes()


def test_a_block_resumes_to_the_bit(tmp_path):
    """In 3-D, with a prescribed motion at either end and nothing that breaks."""
    whole, first, resumed = block(n=5), block(n=5), block(n=5)
    whole.analysis().run(steps=20)
    first.analysis(Checkpoint(tmp_path / "state.npz", when=rbs.last)).run(steps=9)
    resumed.analysis().run(steps=20, resume=tmp_path / "state.npz")
    assert held(resumed.part) == held(whole.part)


def test_the_first_run_needs_no_checkpoint(tmp_path):
    _, analysis = oscillators(tmp_path / "state.npz")
    assert analysis.run(steps=3, resume=tmp_path / "none.npz").steps == 3


def test_a_finished_run_is_not_run_again(tmp_path):
    first, analysis = oscillators(tmp_path / "state.npz")
    analysis.run(steps=5)
    part, analysis = oscillators(tmp_path / "other.npz")
    report = analysis.run(steps=5, resume=tmp_path / "state.npz")
    assert (report.steps, report.step, report.stopped) == (0, 5, "finished")
    assert (part[a] == first[a]).all()


# -- the file -------------------------------------------------------------------------------------------------------


def test_the_file_holds_the_carried_fields_and_nothing_more(tmp_path):
    scene = plate(n=10)
    scene.analysis(Checkpoint(tmp_path / "state.npz", when=rbs.last)).run(steps=2)
    with np.load(tmp_path / "state.npz", allow_pickle=False) as file:
        names = {name.removeprefix("field/plate/") for name in file.files}
        assert names == {"meta", "velocity", "displacement", "force_density", "intact"}
        assert json.loads(str(file["meta"]))["step"] == 2


def test_it_is_written_when_its_trigger_says_so(tmp_path):
    path = tmp_path / "new" / "folder" / "state.npz"
    _, analysis = oscillators(path, when=every(4))
    analysis.run(steps=3)
    assert path.parent.is_dir()  # made before the first step
    assert not path.exists()
    analysis.run(steps=6)
    with np.load(path) as file:
        assert json.loads(str(file["meta"]))["step"] == 4
    assert [each.name for each in path.parent.iterdir()] == ["state.npz"]


def test_the_old_file_is_replaced_and_never_overwritten(tmp_path):
    """Whoever reads it, or a crash in the middle of writing, finds the old one whole."""
    path = tmp_path / "state.npz"
    _, analysis = oscillators(path)
    analysis.run(steps=1)
    content = path.read_bytes()
    with path.open("rb") as reader:
        analysis.run(steps=2)
        assert reader.read() == content != path.read_bytes()


def test_a_write_that_fails_leaves_the_old_file(tmp_path, monkeypatch):
    path = tmp_path / "state.npz"
    _, analysis = oscillators(path)
    analysis.run(steps=2)
    good = path.read_bytes()

    def full(file, **arrays):
        file.write(b"half of it")
        raise OSError(28, "No space left on device")

    monkeypatch.setattr(np, "savez", full)
    with pytest.raises(OSError, match="No space left"):
        analysis.run(steps=3)
    assert path.read_bytes() == good
    assert list(tmp_path.iterdir()) == [path]


def test_what_is_not_finite_never_replaces_a_good_file(tmp_path):
    part = line()

    def spoil(self, clock):
        self[a][1] = np.nan if clock.step == 3 else clock.step

    spoiled = Analysis([Toy(part, spoil, updates=(a,)), Checkpoint(tmp_path / "state.npz")])
    with pytest.raises(NotFinite, match=r"^step 3 .*relation 1 \(Checkpoint\): 'a' of node 1 at \[1.5\] .* is nan"):
        spoiled.run(steps=5, dt=0.1)
    with np.load(tmp_path / "state.npz") as file:
        assert json.loads(str(file["meta"]))["step"] == 2


def test_a_folder_that_cannot_be_written_is_refused_before_the_first_step(tmp_path):
    """Root may write everywhere, but nobody can make a folder below a file."""
    (tmp_path / "file").write_text("in the way")
    toy = Toy(line())
    with pytest.raises(BadInput, match=r"cannot write into the folder .*below: .*: choose another one"):
        Analysis([toy, Checkpoint(tmp_path / "file" / "below" / "state.npz")]).run(steps=1, dt=0.1)
    assert toy.steps == []


@pytest.mark.parametrize("role", ["relation", "exporter"])
def test_it_stands_at_the_end(tmp_path, role):
    """Whatever stood behind it would be left out of the step that a resumed run takes for done."""
    part = line()
    early = Analysis([Checkpoint(tmp_path / "state.npz"), Toy(part, role=role)])
    message = r"relation 0 \(Checkpoint\) stands before Toy 'line': .* put it at the end of the list"
    with pytest.raises(BadInput, match=message):
        early.run(steps=1, dt=0.1)


def test_a_checkpoint_of_a_run_in_pieces_belongs_to_the_scene_as_it_was_given(tmp_path):
    """The second piece begins with changed fields: they are not what the script has set."""

    def scene():
        part = line(horizon=1.0)
        part[a], part[rbs.intact] = 5.0, 1
        snap = Toy(part, lambda self, clock: self[rbs.intact].fill(0), updates=(rbs.intact,))
        return part, [Toy(part, plus(a), updates=(a,)), snap]

    analysis = Analysis(scene()[1], dt=0.1)
    analysis.run(steps=3)
    analysis.append(Checkpoint(tmp_path / "state.npz"))
    analysis.run(steps=6)
    part, relations = scene()
    assert Analysis(relations, dt=0.1).run(steps=7, resume=tmp_path / "state.npz").steps == 1
    assert part[a][0] == 12.0


# -- what is refused ------------------------------------------------------------------------------------------------


@pytest.fixture(scope="module")
def saved(tmp_path_factory) -> Path:
    """The checkpoint of a plate after three steps."""
    path = tmp_path_factory.mktemp("saved") / "state.npz"
    plate(n=12).analysis(Checkpoint(path, when=rbs.last)).run(steps=3)
    return path


@pytest.mark.parametrize(
    ("change", "message"),
    [
        ({"cracked": False}, "differs in broken bonds of 'plate': [0-9a-f]+ in the file, not there in this scene"),
        ({"s0": 0.05}, r"differs in relation 4: BondBased 'plate'\(.*0.04472.* in the file, .*0.05.* in this scene"),
        ({"speed": 21.0}, r"differs in relation 1: BoundaryDomain .*20.0.* in the file, .*21.0.* in this scene"),
        ({"horizon_ratio": 2.1}, "differs in bonds of 'plate'"),
    ],
    ids=["pre-crack", "material", "boundary", "horizon"],
)
def test_another_plate(saved, change, message):
    scene = plate(n=12, **change)
    refused(scene.analysis(), [scene.part], saved, message)


def test_another_number_of_nodes(saved):
    scene = plate(n=14)
    scene.dt = plate(n=12).dt
    message = "differs in nodes of 'plate': 216 in the file, 280 in this scene"
    refused(scene.analysis(), [scene.part], saved, message)


def test_another_time_step(saved):
    scene = plate(n=12)
    message = f"differs in time step: {scene.dt!r} s in the file, {scene.dt / 2!r} s in this scene"
    refused(scene.analysis(), [scene.part], saved, message, dt=scene.dt / 2)


def test_other_cuts(saved):
    """One bond more; with a criterion `intact` changes in every step, so the state at the start must count."""
    scene = plate(n=12)
    holds = scene.part[rbs.intact].copy()
    pairs = list(scene.part.bonds)
    i, j = pairs[0]
    holds[0] = holds[pairs.index((j, i))] = 0
    given = set(scene.part.bonds.fields.given)
    scene.part[rbs.intact] = holds
    scene.part.bonds.fields.given = given
    refused(scene.analysis(), [scene.part], saved, "differs in broken bonds of 'plate'")
    gap = plate(n=12)
    gap.part.bonds.remove(rbs.Segment((0.02, 0.02), (0.024, 0.02)))
    refused(gap.analysis(), [gap.part], saved, "differs in bonds of 'plate'")


def test_looking_at_the_bonds_makes_no_other_scene(tmp_path):
    """`bonds.intact` makes the array when it is first asked for."""

    def scene():
        part = line(horizon=1.0)
        return part, Analysis([Toy(part, plus(a), updates=(a,)), Checkpoint(tmp_path / "state.npz")], dt=0.1)

    scene()[1].run(steps=2)
    part, analysis = scene()
    assert part.bonds.intact.all()
    assert analysis.run(steps=3, resume=tmp_path / "state.npz").steps == 1


def test_given_fields_and_initial_values(saved):
    scene = plate(n=12)
    scene.part[rbs.intact] = scene.part[rbs.intact]  # given, now: also named
    refused(scene.analysis(), [scene.part], saved, "differs in field 'intact' of 'plate': not there in the file")


@pytest.mark.parametrize("each", [a, d])
def test_another_value_of_the_script(tmp_path, each):
    def scene(value):
        part = line()
        part[a] = part[d] = 1.0
        part[each] = value
        return part, Analysis([Toy(part, plus(a), reads=(d,), updates=(a,)), Checkpoint(tmp_path / "s.npz")], dt=0.1)

    scene(2.0)[1].run(steps=2)
    part, analysis = scene(3.0)
    refused(analysis, [part], tmp_path / "s.npz", f"differs in field '{each.name}' of 'line'")


def test_other_relations(tmp_path):
    oscillators(tmp_path / "state.npz")[1].run(steps=2)
    part, analysis = oscillators(tmp_path / "state.npz")
    analysis.relations = [*analysis.relations[:3], *analysis.relations[4:]]
    refused(analysis, [part], tmp_path / "state.npz", "differs in bonds of 'line': list .* lattice .* in this")
    part, analysis = oscillators(tmp_path / "state.npz")
    part.bonds.need_list("as in the file")
    analysis.relations = [*analysis.relations[:3], *analysis.relations[4:]]
    refused(analysis, [part], tmp_path / "state.npz", "differs in relation 3: Toy 'line'.*snap.* in the file, Toy '")
    part, analysis = oscillators(tmp_path / "state.npz")
    e = field("e")
    analysis.relations = [*analysis.relations[:-1], Toy(part, writes=(e,))]
    refused(analysis, [part], tmp_path / "state.npz", "differs in number of relations: 6 in the file, 7 in this")


def test_other_exporters_do_not_matter(tmp_path):
    oscillators(tmp_path / "state.npz")[1].run(steps=2)
    part, analysis = oscillators(tmp_path / "state.npz")
    analysis.relations = [Toy(part, role="exporter", reads=(a,)), *analysis.relations]
    assert analysis.run(steps=4, resume=tmp_path / "state.npz").steps == 2


def test_a_quantity_whose_past_is_missing(saved, tmp_path):
    """The exporter does not count, but what it asks for must have been accumulated from the first step on."""
    scene = plate(n=12)
    exporter = CSVExporter(scene.part, [external_work], tmp_path / "work.csv")
    refused(scene.analysis(exporter), [scene.part], saved, "differs in carried fields .*external_work")
