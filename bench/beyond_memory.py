#!/usr/bin/env python3
"""Begins a training of more photographs than any memory holds: beyond_memory.py VESTA SCENE WORK
    [--views=2000] [--width=4000] [--iterations=40] [--gib=8] [--whole [-- OPTIONS]]

Makes the capture as photograph_memory.py does, trains on it with --memory_budget of --gib until so many iterations
are done, and ends it there. The training is of its usual length: a short one would soon look at all views to see
which Gaussians to take out, and evaluate all at its end. Prints the seconds and the seconds of processor time
until the first iteration is done and of each that follows, and the most memory that was taken (VmHWM), beside the
same of a capture of as many photographs as SCENE has, which all stay decoded.

With --whole: one training of --iterations to its end, of all --views alone, by these OPTIONS of train, and what it took.
Run it where no more than --gib is to be had (a container, a control group) to see that it needs no more."""
import argparse
import json
import os
import pathlib
import re
import resource
import subprocess
import sys
import time

import photograph_memory
import report


def peak_mib(pid):
    status = pathlib.Path(f"/proc/{pid}/status").read_text()
    return int(re.search(r"VmHWM:\s+(\d+)", status)[1]) / 1024


def processor_seconds(pid):
    fields = pathlib.Path(f"/proc/{pid}/stat").read_text().rpartition(")")[2].split()
    return (int(fields[11]) + int(fields[12])) / os.sysconf("SC_CLK_TCK")


def begin_training(vesta, capture, out, gib, iterations):
    """((seconds, of processor) until iteration 1, the same of each later one, MiB taken, lines of notes)"""
    begin = time.monotonic()
    command = [vesta, "train", capture, f"--out={out}", f"--memory_budget={gib}", "--test_every=0", "--seed=1", "--noreport"]
    first, notes = None, []
    with subprocess.Popen(command, stdout=subprocess.PIPE, text=True) as training:
        for line in training.stdout:
            now = (time.monotonic() - begin, processor_seconds(training.pid))
            iteration = re.match(r"adam\s+(\d+)/", line)
            if not iteration:
                notes.append(line.strip())
                continue
            first = first or (int(iteration[1]), now)
            if int(iteration[1]) >= iterations:
                taken = peak_mib(training.pid)
                training.kill()
                later = max(1, int(iteration[1]) - first[0])
                return first[1], [(b - a) / later for a, b in zip(first[1], now)], taken, notes
    raise SystemExit(f"{capture}: the training ended by itself: {' '.join(notes)}")


def train_whole(vesta, capture, out, gib, iterations, options):
    command = [vesta, "train", capture, f"--out={out}", f"--memory_budget={gib}", "--seed=1", f"--iterations={iterations}"]
    begin, before = time.monotonic(), resource.getrusage(resource.RUSAGE_CHILDREN)
    subprocess.run(command + ["--set", "adam.evaluations=1", *options], check=True, stdout=subprocess.DEVNULL)
    seconds, used = time.monotonic() - begin, resource.getrusage(resource.RUSAGE_CHILDREN)
    processor = used.ru_utime + used.ru_stime - before.ru_utime - before.ru_stime
    metrics = json.loads((out / "metrics.json").read_text())
    print("| s | of processor | foreseen, MiB | taken, MiB | Gaussians | test PSNR, dB |\n|---|---|---|---|---|---|")
    print(f"| {seconds:.0f} | {processor:.0f} | {metrics['memory']['predicted_mib']:.0f} "
          f"| {used.ru_maxrss / 1024:.0f} | {metrics['gaussians']} | {metrics['test']['psnr']:.2f} |")


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("vesta")
    parser.add_argument("scene", type=pathlib.Path)
    parser.add_argument("work", type=pathlib.Path)
    parser.add_argument("--views", type=int, default=2000)
    parser.add_argument("--width", type=int, default=4000)
    parser.add_argument("--iterations", type=int, default=40)
    parser.add_argument("--gib", type=float, default=8)
    parser.add_argument("--whole", action="store_true")
    own, options = report.split_at_dashes(sys.argv[1:])
    arguments = parser.parse_args(own)
    if arguments.whole:
        work = arguments.work / str(arguments.views)
        work.mkdir(parents=True, exist_ok=True)
        capture = photograph_memory.make_capture(arguments.scene, work, arguments.views, arguments.width)
        return train_whole(
            arguments.vesta, capture, work / "out", arguments.gib, arguments.iterations, options
        )
    few = len(photograph_memory.read_images(arguments.scene / "sparse/0/images.bin"))
    print("| photographs | until iteration 1, s | of processor | an iteration, s | of processor | taken, MiB |")
    print("|---|---|---|---|---|---|")
    for views in (arguments.views, few):
        work = arguments.work / str(views)
        work.mkdir(parents=True, exist_ok=True)
        capture = photograph_memory.make_capture(arguments.scene, work, views, arguments.width)
        first, each, taken, notes = begin_training(
            arguments.vesta, capture, work / "out", arguments.gib, arguments.iterations
        )
        print(f"| {views} | {first[0]:.1f} | {first[1]:.1f} | {each[0]:.2f} | {each[1]:.2f} | {taken:.0f} |", *notes, sep="\n", flush=True)


if __name__ == "__main__":
    main()
