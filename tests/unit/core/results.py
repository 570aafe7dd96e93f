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
    assert header.split() == ["relation", "calls", "seconds", "share", "Mbond/s", "saved"]
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
    sentence, stored, *measured, last = rest.splitlines()
    assert "finished at step 20" in sentence
    assert stored == "bonds stored: 'bar' as lattice"
    assert [line.split()[0] for line in measured] == ["nodes", "pulled_m", "kinetic_J", "never", "unknown", "good"]
    assert measured[0].split() == ["nodes", "10"]
    assert last.startswith(f"results in {out}{os.sep}  (")
    assert {each.name for each in out.iterdir()} == {"history.csv", "checkpoint.npz", "pulled_bar.py", "result.json"}
    assert (out / "pulled_bar.py").read_bytes() == file.read_bytes()
    result = strict(out / "result.json")
    assert list(result) == ["case", "arguments", "measured", "seconds", "run", "machine"]
    assert (result["case"], result["arguments"]) == ("pulled_bar", {"n": 10, "speed": 2.5})
    assert result["run"]["stopped"] == "finished"
    assert [row["calls"] for row in result["run"]["relations"]] == [20] * 10 + [5]
    assert set(result["machine"]) == {"python", "numpy", "platform", "cores"}
    assert result["seconds"] > result["run"]["seconds"] > 0
