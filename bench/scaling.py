#!/usr/bin/env python3
"""How a problem scales over processes, and what a model foresees for more of them.

  bench/scaling.py SCALING OUT.json [--processes 1,2,4] [--threads 1] [--rounds 3] [--networks 1:10,10:0.1,100:0.02]
                   [--mpirun "mpirun --oversubscribe --bind-to none"] -- bal --cameras 200 --points 100000
  bench/scaling.py SCALING OUT.json ... -- splats SCENE SPLAT.ply

SCALING: build/release/bench/scaling of a build with VESTA_MPI. Runs it for each number of processes, and once in one process without
parts, in turn, --rounds times; medians. Then, for each network (Gbit/s : milliseconds a message), a run with 2 processes whose
exchanges wait as long as such a network would take, beside what the model says.

The model, of a product of H: T(P) = (W + V) / P + 2 latency + bytes(P) / bandwidth, where W is the work of the problem and V what
cutting it into parts adds, both from the runs with one process (with and without parts); bytes(P) in proportion to (P - 1) / P, those of a
dense vector of n values, 2 n (P - 1) / P, or fewer, by what 2 processes received. It tells for each network at how many processes a step stops getting faster by a tenth from doubling them.
"""
import argparse
import json
import shlex
import statistics
import subprocess
import sys
import tempfile
from pathlib import Path

import report

MIB = 2**20


def run(words):
    with tempfile.TemporaryDirectory() as folder:
        out = Path(folder) / "row.json"
        subprocess.run([*words, f"--json={out}"], check=True, stdout=subprocess.DEVNULL)
        return json.loads(out.read_text())["rows"][0]


def medians(rows):
    """One row of the medians of several."""
    return {name: statistics.median(row[name] for row in rows) if isinstance(value, (int, float)) else value
            for name, value in rows[0].items()}


def product_seconds(one, plain, received_by_two, processes, network):
    """(work of the problem, that of cutting it, exchange) of a product of H on `processes`; network: (bytes a second, seconds a message)."""
    parts, alone = one["product_ms"] / 1e3, plain["product_ms"] / 1e3
    own = max(parts - alone, 0)
    bytes_a_second, latency = network
    received = 2 * received_by_two * (processes - 1) / processes
    exchange = 0 if processes == 1 else 2 * latency + received / bytes_a_second
    return alone / processes, own / processes, exchange


def foresee(one, plain, received_by_two, networks):
    print(f"\n{'Gbit/s':>7} {'ms':>6} | seconds of a product on 1, 2, 4, ... processes, up to the number of parts; * where doubling gains under a tenth")
    rows = []
    for gbit, milliseconds in networks:
        network = (gbit * 1e9 / 8, milliseconds * 1e-3)
        times = {}
        for power in range(int(one["parts"]).bit_length()):
            times[2**power] = sum(product_seconds(one, plain, received_by_two, 2**power, network))
        best = next((p for p in times if 2 * p in times and times[2 * p] > 0.9 * times[p]), None)
        print(f"{gbit:7g} {milliseconds:6g} | " +
              " ".join(f"{seconds:.4g}{'*' if p == best else ''}" for p, seconds in times.items()))
        rows.append({"gbit": gbit, "milliseconds": milliseconds, "seconds": times, "stops_at": best})
    return rows


def main():
    own, command = report.split_at_dashes(sys.argv[1:])
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("scaling", type=Path)
    parser.add_argument("out", type=Path)
    parser.add_argument("--processes", default="1,2,4")
    parser.add_argument("--threads", default="1")
    parser.add_argument("--rounds", type=int, default=3)
    parser.add_argument("--networks", default="1:10,10:0.1,100:0.02")
    parser.add_argument("--mpirun", default="mpirun --oversubscribe --bind-to none")
    args = parser.parse_args(own)
    if not command:
        parser.error("what to measure stands after --: bal or splats")
    processes = [int(p) for p in args.processes.split(",")]
    networks = [tuple(map(float, n.split(":"))) for n in args.networks.split(",")]
    program = [str(args.scaling), *command]
    mpirun = shlex.split(args.mpirun)

    def on(count, *more):
        return run([*mpirun, "-n", str(count), *program, f"--threads={args.threads}", *more])

    kinds = {"plain": lambda: run([*program, f"--threads={args.threads}", "--plain=yes"]),
             "plain, 2 threads": lambda: run([*program, "--threads=2", "--plain=yes"]),
             "parts, 2 threads": lambda: run([*mpirun, "-n", "1", *program, "--threads=2"]),
             **{f"{p} processes": (lambda p=p: on(p)) for p in processes}}
    rounds = {kind: [] for kind in kinds}
    for _ in range(args.rounds):
        for kind, measure in kinds.items():
            rounds[kind].append(measure())
    rows = [{"kind": kind, **medians(measured)} for kind, measured in rounds.items()]
    columns = ("linearize_ms", "product_ms", "reduced_product_ms", "cost_ms", "step_ms", "product_mib",
               "product_mib_foreseen", "peak_mib")
    print(f"{'':>18} " + " ".join(f"{c:>20}" for c in columns))
    for row in rows:
        print(f"{row['kind']:>18} " + " ".join(f"{row[c]:20.4g}" for c in columns))

    by_kind = {row["kind"]: row for row in rows}
    one, plain = by_kind["1 processes"], by_kind["plain"]
    print("\n2 processes that wait as over a network, a product: measured, and that of the model with 2 processes as measured here")
    slowed = []
    two = by_kind.get("2 processes")
    here = (two or one)["product_ms"] / 1e3
    received_by_two = two["product_mib"] * MIB if two else one["parameters"] * one["scalar_bytes"]
    for gbit, milliseconds in networks:
        measured = statistics.median(on(2, f"--gbit={gbit}", f"--latency_ms={milliseconds}")["product_ms"] / 1e3
                                     for _ in range(args.rounds))
        exchange = product_seconds(one, plain, received_by_two, 2, (gbit * 1e9 / 8, milliseconds * 1e-3))[2]
        print(f"{gbit:7g} Gbit/s {milliseconds:6g} ms: {measured:.4g} s, foreseen {here + exchange:.4g} s")
        slowed.append({"gbit": gbit, "milliseconds": milliseconds, "measured": measured, "foreseen": here + exchange})
    rows += [{"kind": "slowed", **row} for row in slowed]
    rows += [{"kind": "foreseen", **row} for row in foresee(one, plain, received_by_two, networks)]
    report.write_json(args.out, "scaling", rows, [])


if __name__ == "__main__":
    main()
