#!/usr/bin/env python3
"""Python against C: a sweep of 10 000 rows through the package and through the library alone, and a session of 10 000
steps with inputs between them. python.py BUILD SOURCE

The baseline is a program in C of the same run, which asks the same question of the same model."""
import json
import os
import subprocess
import sys
import tempfile
import time
from pathlib import Path

build, source = Path(sys.argv[1]).resolve(), Path(sys.argv[2]).resolve()
sys.path.insert(0, str(build / "python"))
import kmech

ROWS, ROUNDS = 10000, 7
MODEL = source / "models/brake.json"
PROGRAM = r"""
#include <kmech/kmech.h>
#include <stdio.h>
#include <time.h>
static double seconds(void) { struct timespec t; clock_gettime(CLOCK_MONOTONIC, &t); return t.tv_sec + 1e-9 * t.tv_nsec; }
int main(int argc, char **argv) {
  km_error e; km_model *model; km_mechanism *m; km_state *s; double best = 1e9, sum = 0;
  if (argc < 2 || km_model_read_file(argv[1], NULL, &model, &e) || km_mechanism_compile_at(model, NULL, 0, NULL, 0, &m, &s, &e)) return 1;
  for (int round = 0; round < %d; ++round) {
    km_state *twin; km_question *q; double values[64];
    km_option_value range = {.numbers = {20, 32}}, steps = {.whole = %d};
    double start = seconds();
    km_state_coordinates(m, s, values, &e);
    if (km_state_create(m, &twin, &e) || km_state_set_coordinates(m, twin, values, &e) || km_assemble(m, twin, NULL, &e)) return 2;
    if (km_question_create(m, "mobility", &q, &e) || km_question_set(q, "range", &range, &e) ||
        km_question_set(q, "steps", &steps, &e) || km_question_compute(q, twin, &e)) return 3;
    const km_table *t = km_question_table(q);
    sum += km_table_row(t, km_table_rows(t) - 1)[3];
    km_question_free(q); km_state_free(twin);
    double took = seconds() - start;
    best = took < best ? took : best;
  }
  printf("%%.9g %%.3g\n", best, sum);
  return 0;
}
""" % (ROUNDS, ROWS)


def in_python(mechanism):
    best = 1e9
    for _ in range(ROUNDS):
        start = time.perf_counter()
        column = mechanism.mobility(range=(20, 32), steps=ROWS).table["q.K"]
        assert len(column) == ROWS + 1
        del column
        best = min(best, time.perf_counter() - start)
    return best


def session_time(steps, calls):
    """Time of a session of `steps` steps, in `calls` calls with an input each."""
    best = 1e9
    for _ in range(ROUNDS):
        session = kmech.Session(kmech.load(source / "models/slider_crank.json"), step=0.001)
        start = time.perf_counter()
        for _ in range(calls):
            session.force("A", -10.0 * session.v("A"))
            session.step(steps // calls)
        best = min(best, time.perf_counter() - start)
    return best


with tempfile.TemporaryDirectory() as work:
    Path(work, "sweep.c").write_text(PROGRAM)
    subprocess.run([os.environ.get("CC", "cc"), "-O2", "-D_GNU_SOURCE", "sweep.c", "-o", "sweep", f"-I{source}/lib/include",
                    f"-I{build}/lib/include", f"-L{build}/lib", "-lkmech", f"-Wl,-rpath,{build}/lib"], check=True, cwd=work)
    mechanism, c, python = kmech.load(MODEL).mechanism(), [], []
    for _ in range(15):  # in turn, so that both meet the same noise; the least of each is what it costs
        c.append(float(subprocess.run([f"{work}/sweep", str(MODEL)], capture_output=True, text=True, check=True).stdout.split()[0]))
        python.append(in_python(mechanism))
print(f"python_sweep: C {1e3 * min(c):.3f} ms, Python {1e3 * min(python):.3f} ms", file=sys.stderr)
print(json.dumps({"bench": "python", "figure": "sweep of 10000 rows, Python/C", "value": round(min(python) / min(c), 4)}))
calls, alone = session_time(ROWS, ROWS), session_time(ROWS, 1)
print(f"python_session: {ROWS} calls {calls:.3f} s, one call {alone:.3f} s", file=sys.stderr)
print(json.dumps({"bench": "python", "figure": f"session of {ROWS} steps with an input each, s beside the integration",
                  "value": round(calls - alone, 4)}))
