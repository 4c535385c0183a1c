#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Measures how a problem scales over MPI processes, and predicts the time for more of them with a model.

  bench/scaling.py SCALING OUT.json [--processes 1,2,4] [--threads 1] [--rounds 3] [--weak] [--networks 1:10,10:0.1,100:0.02]
                   [--links_only] [--mpirun "mpirun --oversubscribe --bind-to none"] -- bal --cameras 200 --points 100000
  bench/scaling.py SCALING OUT.json ... -- splats SCENE SPLAT.ply

SCALING: build/release/bench/scaling of a build with VESTA_MPI. The script runs it for each number of processes, and in one process
without parts. It repeats these runs --rounds times in alternation and reports medians. With --weak, P processes get a problem that is
P times as large (cameras and points, or --views).

If this machine allows network namespaces, the script then measures two processes on two simulated nodes (tools/two_nodes.py): over an
unlimited link and over a link of 1 Gbit/s and 10 ms, in alternation, with eager messages and with rendezvous messages. It also predicts
the slow link from the fast one with the model. --links_only runs only this part.

Model of a product with H: T(P) = (W + V) / P + trips latency + bytes(P) / bandwidth. W is the work of the problem, and V the extra work of
splitting it into parts; both come from the runs with one process (with and without parts). bytes(P) is proportional to (P - 1) / P and is
scaled to the bytes that 2 processes received; for a dense vector of n values it is 2 n (P - 1) / P. A product has two exchanges with
messages of different lengths. A message takes one trip, or three trips if it is longer than Open MPI's eager limit over TCP
(btl_tcp_eager_limit). For each of --networks (Gbit/s : milliseconds of one-way latency) the script prints the number of processes at
which doubling makes a product less than 10 % faster.
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
# Open MPI's default btl_tcp_eager_limit in bytes, and one that only the longest message of a large bundle exceeds.
EAGER, ALL_EAGER = 64 * 1024, 4 * MIB
SLOW = (1.0, 10.0)  # Gbit/s, milliseconds
TWO_NODES = Path(__file__).parent.parent / "tools" / "two_nodes.py"


def run(words):
    with tempfile.TemporaryDirectory() as folder:
        out = Path(folder) / "row.json"
        subprocess.run([*words, f"--json={out}"], check=True, stdout=subprocess.DEVNULL)
        return json.loads(out.read_text())["rows"][0]


def medians(rows):
    """Returns one row with the medians of several rows."""
    return {name: statistics.median(row[name] for row in rows) if isinstance(value, (int, float)) else value
            for name, value in rows[0].items()}


def heard(row, name):
    """Bytes that rank 0 receives in the two exchanges of a product: the all-to-all and the all-gather."""
    gathered = row[f"{name}_gathered_mib"] * MIB
    return row[f"{name}_mib"] * MIB - gathered, gathered


def exchange_seconds(received_by_two, processes, network, eager=EAGER):
    """Seconds that a product spends on communication. received_by_two: heard() of two processes; network: (Gbit/s, ms)."""
    if processes == 1:
        return 0
    seconds = 0
    for received in received_by_two:
        message = received * 2 / processes  # from each other process
        trips = 1 if message <= eager else 3
        seconds += trips * network[1] * 1e-3 + message * (processes - 1) / (network[0] * 1e9 / 8)
    return seconds


def foresee(one, plain, received_by_two, networks):
    print(f"\n{'Gbit/s':>7} {'ms':>6} | seconds of a product on 1, 2, 4, ... processes, up to the number of parts; *: doubling gains less than 10 %")
    rows = []
    work = max(one["product_ms"], plain["product_ms"]) / 1e3
    for network in networks:
        counts = [2**power for power in range(int(one["parts"]).bit_length())]
        times = {p: work / p + exchange_seconds(received_by_two, p, network) for p in counts}
        best = next((p for p in times if 2 * p in times and times[2 * p] > 0.9 * times[p]), None)
        print(f"{network[0]:7g} {network[1]:6g} | " +
              " ".join(f"{seconds:.4g}{'*' if p == best else ''}" for p, seconds in times.items()))
        rows.append({"gbit": network[0], "milliseconds": network[1], "seconds": times, "stops_at": best})
    return rows


def can_make_nodes():
    return subprocess.run([sys.executable, TWO_NODES, "--", "true"], check=False).returncode == 0


def over_links(program, rounds):
    """Measures two processes on two nodes over a fast and a slow link, and predicts the slow link from the fast one."""
    def on_nodes(eager, link=()):
        words = [sys.executable, str(TWO_NODES), f"--mca=btl_tcp_eager_limit={eager}", *link, "--", *program, "--threads=1"]
        return run(words)

    rows = []
    slow = (f"--gbit={SLOW[0]}", f"--latency_ms={SLOW[1]}")
    for eager in (EAGER, ALL_EAGER):
        pairs = [(on_nodes(eager), on_nodes(eager, slow)) for _ in range(rounds)]
        for name, sent in (("product", "product"), ("reduced_product", "reduced")):
            fast, measured = (statistics.median(pair[k][f"{name}_ms"] for pair in pairs) / 1e3 for k in (0, 1))
            if fast == 0:
                continue
            received = heard(pairs[0][0], sent)
            foreseen = fast + exchange_seconds(received, 2, SLOW, eager)
            print(f"{name}, messages of {received[0] / 1024:.0f} and {received[1] / 1024:.0f} KiB, eager up to {eager // 1024} KiB: {fast:.4g} s, over "
                  f"{SLOW[0]:g} Gbit/s and {SLOW[1]:g} ms {measured:.4g} s, predicted {foreseen:.4g} s ({foreseen / measured - 1:+.0%})")
            rows.append({"kind": f"slow link, {name}", "eager": eager, "to_all_bytes": received[0], "gathered_bytes": received[1],
                         "fast": fast, "measured": measured, "foreseen": foreseen})
    return rows


def larger(command, times):
    """Returns the command for a problem that is `times` as large."""
    sizes = ("--cameras", "--points") if command[0] == "bal" else ("--views",)
    return [str(int(word) * times) if k > 0 and command[k - 1] in sizes else word for k, word in enumerate(command)]


def main():
    own, command = report.split_at_dashes(sys.argv[1:])
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("scaling", type=Path)
    parser.add_argument("out", type=Path)
    parser.add_argument("--processes", default="1,2,4")
    parser.add_argument("--threads", default="1")
    parser.add_argument("--rounds", type=int, default=3)
    parser.add_argument("--weak", action="store_true")
    parser.add_argument("--links_only", action="store_true", help="measure only the two simulated nodes")
    parser.add_argument("--networks", default="1:10,10:0.1,100:0.02")
    parser.add_argument("--mpirun", default="mpirun --oversubscribe --bind-to none")
    args = parser.parse_args(own)
    if not command:
        parser.error("name the problem after --: bal or splats")
    if args.weak and larger(command, 2) == command:
        parser.error("--weak: give the size for one process as --cameras N --points N, or as --views N")
    processes = [int(p) for p in args.processes.split(",")]
    networks = [tuple(map(float, n.split(":"))) for n in args.networks.split(",")]
    program = [str(args.scaling), *command]
    mpirun = shlex.split(args.mpirun)

    if args.links_only:
        if not can_make_nodes():
            parser.error("--links_only: this machine does not allow network namespaces")
        report.write_json(args.out, "scaling", over_links(program, args.rounds), [])
        return

    def on(count):
        sized = [str(args.scaling), *larger(command, count)] if args.weak else program
        return run([*mpirun, "-n", str(count), *sized, f"--threads={args.threads}"])

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
    if args.weak:
        report.write_json(args.out, "scaling", rows, [])
        return
    two = by_kind.get("2 processes")
    received_by_two = heard(two, "product") if two else (one["parameters"] * one["scalar_bytes"] / 2,) * 2
    if can_make_nodes():
        print()
        rows += over_links(program, args.rounds)
    rows += [{"kind": "foreseen", **row} for row in foresee(one, plain, received_by_two, networks)]
    report.write_json(args.out, "scaling", rows, [])


if __name__ == "__main__":
    main()
