"""Looking at what the command line leaves behind."""

from __future__ import annotations

import json
import os
import re
from pathlib import Path


def strict(path: Path) -> dict:
    """A JSON file that holds nothing which JSON does not know."""

    def refuse(word):
        raise AssertionError(f"{path} holds {word}")

    return json.loads(path.read_text(encoding="utf-8"), parse_constant=refuse)


def check_run(out: Path, file: Path, stdout: str) -> None:
    """What a run of the bar with n=10 leaves behind and prints."""
    table, rest = stdout.split("\n20 steps in ")
    header, *rows = table.splitlines()
    assert header.split() == ["relation", "calls", "items", "seconds", "share", "ns/item", "Mbond/s", "saved"]
    assert [re.split(r"\s{2,}", row.strip())[0] for row in rows] == [
        "0 Kick 'bar'",
        "1 BoundaryDomain 'bar'",
        "2 BoundaryDomain 'bar'",
        "3 Drift 'bar'",
        "4 BondBased 'bar'",
        "5 Kick 'bar'",
        "6 BoundaryDomain 'bar'",
        "7 BoundaryDomain 'bar'",
        "8 KineticEnergy 'bar'",
        "9 CSVExporter 'bar' history.csv",
        "10 Checkpoint",
    ]
    sentence, stored, *memory, last = rest.splitlines()
    measured, memory = memory[-6:], memory[:-6]
    assert "finished at step 20" in sentence
    assert stored == "bonds stored: 'bar' as lattice"
    assert [line.split()[0] for line in measured] == ["nodes", "pulled_m", "kinetic_J", "never", "unknown", "good"]
    assert measured[0].split() == ["nodes", "10"]
    assert memory[0].split() == ["of", "what", "at", "memory"]
    assert {"displacement", "force_density"} <= {line.split()[1] for line in memory[1:]}
    assert re.fullmatch(rf"results in {re.escape(str(out) + os.sep)}  \(\d+\.\d s\): rbs show .*", last)
    files = {"history.csv", "checkpoint.npz", "pulled_bar.py", "result.json", "run.log"}
    assert {each.name for each in out.iterdir()} == files
    check_log(out / "run.log", file, stdout)
    assert (out / "pulled_bar.py").read_bytes() == file.read_bytes()
    result = strict(out / "result.json")
    assert list(result) == ["case", "arguments", "measured", "seconds", "run", "machine"]
    assert (result["case"], result["arguments"]) == ("pulled_bar", {"n": 10, "speed": 2.5})
    assert result["run"]["stopped"] == "finished"
    assert [row["calls"] for row in result["run"]["relations"]] == [20] * 10 + [5]
    assert set(result["machine"]) == {"python", "numpy", "platform", "cores"}
    assert result["seconds"] > result["run"]["seconds"] > 0


def check_log(path: Path, file: Path, stdout: str) -> None:
    """The log tells the command, what was printed, and nothing else."""
    date = r"\d{4}-\d\d-\d\d \d\d:\d\d:\d\d "
    lines = path.read_text(encoding="utf-8").splitlines()
    records = [re.sub(f"^{date}", "", line) for line in lines if re.match(date, line)]
    assert records[0].split() == ["process", "rbs", "run", *records[0].split()[3:]]
    assert file.name in records[0]
    assert re.fullmatch(
        r"process  pulled bar: from step 0 to 20, dt \S+ s, 10 nodes, 48 directed bonds, \S+ kB", records[1]
    )
    assert records[2].startswith("timing      relation")
    table = [line.removeprefix("    ") for line in lines if line.startswith("    ")]
    for line in stdout.splitlines()[1:-1]:  # header, and a last line with the folder as it was typed
        assert line in table or f"process  {line}" in records, line
