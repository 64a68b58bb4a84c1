"""A redundant arm follows a path: kredund's methods side by side."""
import os
from pathlib import Path

import kmech

source = Path(os.environ.get("KMECH_SOURCE", Path(__file__).resolve().parents[2]))
study = kmech.load_study(source / "studies" / "thesis_line" / "study.json")
for number, method in enumerate(study.methods[:3]):
    track = study.track(number)
    end = "to its end" if track.complete else "not to its end"
    print(f"{method}: {len(track.table)} samples, {end}; the objective is {track.summary.objective_mean:.4f} on average")
