"""`rbs show DIR`: what a run has left."""

from __future__ import annotations

import json
import shutil
from pathlib import Path

import pytest

from rbs_core.command import main


@pytest.fixture(scope="module")
def run_once(tmp_path_factory) -> Path:
    """The results of a run of cracked_strip.py."""
    folder = tmp_path_factory.mktemp("strip")
    file = shutil.copy(Path(__file__).with_name("cracked_strip.py"), folder)
    assert main(["run", str(file), "--set", "n=14", "--out", str(folder / "out"), "--level", "off"]) == 0
    return folder / "out"


@pytest.fixture
def out(run_once, tmp_path) -> Path:
    return Path(shutil.copytree(run_once, tmp_path / "out"))


def told(capsys, *words: object) -> str:
    assert main(["show", *map(str, words)]) == 0
    return capsys.readouterr().out


def refused(capsys, *words: object) -> str:
    assert main(["show", *map(str, words)]) == 2
    printed = capsys.readouterr()
    assert printed.out == ""
    return printed.err


def test_everything(out, capsys):
    (out / "damage_000009.png").touch()
    (out / "damage_000030.png").touch()
    (out / "frame_1.vtu").touch()
    lines = told(capsys, out).splitlines()
    assert lines[0] == "cracked_strip(n=14)"
    assert lines[1].split()[:3] == ["relation", "calls", "items"]
    assert any(line.startswith("30 steps in ") for line in lines)
    measured = lines.index("measured")
    assert lines[measured + 1].split() == ["nodes", "98"]
    files = {line.split()[0]: line for line in lines[lines.index("files") + 1 :]}
    assert files["strip.vtkhdf"].endswith(" s: damage, displacement")
    assert "3 frames, " in files["strip.vtkhdf"]
    assert files["history.csv"].endswith("3 rows: step, time [s], kinetic_energy [J]")
    assert files["run.log"].endswith("messages")
    assert files["2"] == f"  2 pictures, the last one is {out / 'damage_000030.png'}"
    assert files["1"] == "  1 files of single frames"


def test_the_table_is_the_one_that_the_run_has_printed(out, capsys):
    text = told(capsys, out)
    log = (out / "run.log").read_text()
    table = [line[4:] for line in log.splitlines() if line.startswith("    ")]
    assert table
    assert all(line in text.splitlines() for line in table)


def test_a_run_without_result(out, capsys):
    (out / "result.json").unlink()
    assert told(capsys, out).startswith("no result.json: the run goes on, ")


def test_numbers_that_are_not_finite(out, capsys):
    result = json.loads((out / "result.json").read_text())
    result["measured"] = {"tip": None, "energy": 0.5, "path": [1.0, 2.0]}
    (out / "result.json").write_text(json.dumps(result))
    lines = told(capsys, out).splitlines()
    first = lines.index("measured")
    assert [line.split() for line in lines[first + 1 : first + 3]] == [["tip", "not", "finite"], ["energy", "0.5"]]
    assert lines[first + 3] == "files"


@pytest.mark.parametrize(
    "text", ["", "[]", "{}", '{"run": 3, "arguments": {}, "measured": {}}', '{"run": {"relations": [1]}}']
)
def test_a_result_that_is_none(out, capsys, text):
    (out / "result.json").write_text(text)
    assert "result.json is no result of `rbs run` (" in refused(capsys, out)


def test_broken_files_are_told_and_the_others_shown(out, capsys):
    (out / "strip.vtkhdf").write_bytes((out / "strip.vtkhdf").read_bytes()[:3000])
    (out / "history.csv").write_bytes(b"\xff\xfe\xfa")
    lines = {line.split()[0]: line for line in told(capsys, out).splitlines() if line.split()}
    assert "cannot be read: " in lines["strip.vtkhdf"]
    assert "cannot be read: " in lines["history.csv"]
    assert lines["run.log"].endswith("messages")


# -- one frame ------------------------------------------------------------------------------------------------------


def test_ranges_of_a_frame(out, capsys):
    first, nodes, header, *fields = told(capsys, out, "--frame", 1).splitlines()
    assert first.startswith(f"{out / 'strip.vtkhdf'}, frame 1 of 3, time ")
    assert nodes.startswith("  98 nodes in [")
    assert header.split() == ["field", "unit", "least", "mean", "most"]
    rows = {line.split()[0]: line.split()[1:] for line in fields}
    assert rows["damage"][0] == "1"
    assert rows["displacement"][0] == "m"
    assert rows["displacement"][-1] == "(magnitude)"
    least, mean, most = map(float, rows["damage"][1:4])
    assert 0.0 == least < mean < most < 1.0


def test_one_field_of_the_last_frame(out, capsys):
    lines = told(capsys, out, "--field", "damage").splitlines()
    assert "frame 2 of 3" in lines[0]
    assert [line.split()[0] for line in lines[3:]] == ["damage"]


def test_a_picture_of_a_frame(out, tmp_path, capsys):
    picture = tmp_path / "last.png"
    text = told(capsys, out, "--picture", picture, "--field", "displacement")
    assert text.splitlines()[-1] == f"  picture {picture}, by displacement"
    assert picture.read_bytes().startswith(b"\x89PNG")
    assert told(capsys, out, "--picture", picture, "--frame", "0").endswith("by damage\n")


def test_the_last_picture_is_opened(out, monkeypatch, tmp_path, capsys):
    opened = []
    monkeypatch.setattr("rbs_core.command.show.webbrowser.open", lambda uri: opened.append(uri) or True)
    assert "has no picture: draw one, rbs show" in refused(capsys, out, "--open")
    for name in ("damage_000009.png", "damage_000030.png"):
        (out / name).touch()
    assert told(capsys, out, "--open") == ""
    told(capsys, out, "--picture", tmp_path / "mine.png", "--open")
    assert opened == [(out / "damage_000030.png").as_uri(), (tmp_path / "mine.png").as_uri()]
    monkeypatch.setattr("rbs_core.command.show.webbrowser.open", lambda uri: False)
    assert "nothing here can show pictures: look at" in refused(capsys, out, "--open")


def test_which_of_several_series(out, capsys):
    shutil.copy(out / "strip.vtkhdf", out / "other.vtkhdf")
    assert "has several series of frames: say which, --series other.vtkhdf or strip.vtkhdf" in refused(
        capsys, out, "--frame", 0
    )
    assert told(capsys, out, "--frame", 0, "--series", "other.vtkhdf").startswith(f"{out / 'other.vtkhdf'}, frame 0")
    assert "has no series othr.vtkhdf (did you mean other.vtkhdf or strip.vtkhdf?)" in refused(
        capsys, out, "--series", "othr.vtkhdf", "--frame", 0
    )


@pytest.mark.parametrize(
    ("words", "message"),
    [
        (["--frame", "3"], "strip.vtkhdf has no frame 3: it has frames 0 to 2 (-1 is the last)"),
        (["--field", "damge"], "has no field 'damge' (did you mean damage?); it has damage, displacement"),
        (["--picture", "a.gif"], "--picture a.gif: the name must end with .png"),
        (["--picture", "no/where/a.png"], "there is no folder no/where: make it first"),
    ],
)
def test_what_is_not_there(out, capsys, words, message):
    assert message in refused(capsys, out, *words)


def test_folders_without_results(tmp_path, capsys):
    assert "there is no folder" in refused(capsys, tmp_path / "none")
    assert "holds no files: run something into it, rbs run FILE.py --out" in refused(capsys, tmp_path)
    assert "has no frames (.vtkhdf, .pvd, .h5, .hdf5): add an exporter" in refused(capsys, tmp_path, "--frame", 0)
