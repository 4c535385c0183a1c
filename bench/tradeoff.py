#!/usr/bin/env python3
"""Time, memory and size of a training against what it reaches on the test views, over every option that trades one for
the other, and the front of those that no other beats.

  bench/tradeoff.py SCENE [--out DIR] [--budget SECONDS] [--seeds 0,1,2] [--lengths 0.25,1,...]
                    [--knobs NAME ROOM.KEY=V1,V2 ...] [-- flags for `vesta train`]

First the default at all lengths, and each value of each knob alone at some of them. Then those values together that
lay on the front of time against PSNR or SSIM. Each run is a line of OUT/records.jsonl, appended when it ends; a run
that has a line is not run again, so that one may break off (Ctrl-C) and go on, or ask for more. With --budget 0 nothing
is run. Prints the fronts and what each setting gains beside the others at the same cost, and writes OUT/front.json and,
where Python has matplotlib, OUT/front.png and .svg. How to read them: docs/tradeoff.md.
"""
import argparse
import math
import sys
from pathlib import Path

import report
from training_front import front, knobs, runs, show

ROOT = Path(__file__).resolve().parents[1]
FIRST_ROUND = 0.7  # of the budget; the rest is for the second


def say(line):
    print(line, file=sys.stderr, flush=True)


def numbers(kind, is_valid):
    def parse(text):
        values = [kind(word) for word in text.split(",")]
        if not all(map(is_valid, values)):
            raise ValueError
        return values

    parse.__name__ = "list of numbers"
    return parse


SEEDS = numbers(int, lambda value: value >= 0)
FACTORS = numbers(float, lambda value: 0 < value < math.inf)


def arguments_of(words):
    words, flags = report.split_at_dashes(words)
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("scene", type=Path)
    parser.add_argument("--program", type=Path, default=ROOT / "build/release/vesta")
    parser.add_argument("--out", type=Path, help="folder of the records [out/tradeoff/NAME_OF_SCENE]")
    parser.add_argument("--preset", default="balanced", help="whose options are the default [balanced]")
    parser.add_argument("--downscale", type=int, default=1, help="measure, and train by default, at this size [1]")
    parser.add_argument("--seeds", type=SEEDS, default=[0, 1, 2], help="[0,1,2]")
    parser.add_argument("--lengths", type=FACTORS, default=list(knobs.LENGTHS),
                        help=f"factors on the iterations that the scene requires [{','.join(map(str, knobs.LENGTHS))}]")
    parser.add_argument("--knob_lengths", type=FACTORS, help="those at which knobs are tried [every second of them]")
    parser.add_argument("--knobs", nargs="+", default=list(knobs.KNOBS), metavar="KNOB",
                        help=f"of {', '.join(knobs.KNOBS)}, or ROOM.KEY=V1,V2 [all of them]")
    parser.add_argument("--rounds", type=int, choices=(1, 2), default=2)
    parser.add_argument("--budget", type=float, default=math.inf, help="seconds that all of it may take [no limit]")
    parser.add_argument("--by", choices=("seconds", "work"), default="seconds",
                        help="what fronts of time are of: seconds, or counted work where the machine is busy [seconds]")
    parser.add_argument("--retry", action="store_true", help="run those again that failed")
    options = parser.parse_args(words)
    options.flags = flags
    options.knob_lengths = options.knob_lengths or sorted(options.lengths)[1::2] or options.lengths
    options.out = options.out or ROOT / "out/tradeoff" / options.scene.resolve().name
    try:
        options.knobs = dict(map(knobs.parse_knob, options.knobs))
    except ValueError as error:
        parser.error(str(error))
    if not options.scene.is_dir():
        parser.error(f"{options.scene}: no such scene folder")
    return options


def check_comparable(records, program):
    """Fails where records of this scene are of another machine, and says where they are of another commit."""
    rows, like = records.of(program), program.blank({})
    for row in rows:
        if row["machine"] != like["machine"]:
            sys.exit(f"tradeoff.py: {records.path} has runs of another machine, {row['machine']}: choose another --out")
    commits = {row["commit"] for row in rows} - {like["commit"]}
    if commits:
        say(f"{records.path} has runs of other commits, taken as they are: {', '.join(sorted(commits))}")


def measure(options, program, records):
    """Both rounds; returns how many runs the budget left out."""
    chosen = knobs.that_change(program.base, options.knobs)
    first = knobs.one_at_a_time(program.base, chosen, options.lengths, options.knob_lengths, options.seeds)
    share = FIRST_ROUND if options.rounds > 1 else 1
    left_out, spent = runs.carry_out(first, program, records, options.budget * share, say)
    if options.rounds == 1:
        return left_out
    points = front.points_of(records.of(program), program.base)
    good = {length: front.good_settings(points, chosen.values(), length, options.by) for length in options.knob_lengths}
    second = knobs.combined(program.base, good, options.lengths, options.seeds)
    more, _ = runs.carry_out(second, program, records, options.budget - spent, say)
    return left_out + more


def target_of(program, points, by):
    """How far the default lies under the front of all others at its own cost. None where it was not run."""
    default = next((point for point in points
                    if not point["settings"] and point["length"] == program.base[knobs.LENGTH]), None)
    if default is None:
        return []
    others = [point for point in points if point is not default]
    best = front.best_at(front.front_of(others, by, "psnr"), by, "psnr", default[by])
    gap = 0 if best is None else max(0, best - default["psnr"])
    return [{"name": f"the default under the front of {by} and PSNR", "value": gap, "unit": "dB", "goal": 0.1,
             "met": gap <= 0.1}]


def tell(options, program, records):
    rows = records.of(program)
    points = front.points_of(rows, program.base)
    failed = sum("failed" in row for row in rows)
    if failed:
        say(f"{failed} runs failed; {records.path} says why, --retry runs them again")
    if not points:
        say("no run to show")
        return
    fronts = show.panels(options.by)
    for x, y in fronts:
        print(f"\n{show.COSTS[x]} and {show.QUALITIES[y]}\n\n{show.front_table(points, x, y)}")
    print(f"\nEach setting beside the front of the runs without it, at the same {options.by}\n\n"
          f"{show.beside_table(points, options.by)}\n")
    targets = target_of(program, points, options.by)
    report.print_targets(targets)
    for point in points:
        point["fronts"] = [f"{x}, {y}" for x, y in fronts if point in front.front_of(points, x, y)]
        point["beside others"] = front.beside_others(point, points, options.by)
    report.write_json(options.out / "front.json", "tradeoff", points, targets)
    plot = options.out / "front.png"
    try:
        show.save(show.figure_of(points, options.by, options.scene.resolve().name), plot)
    except ImportError:
        say(f"no plot: {sys.executable} has no matplotlib; on Debian: apt-get install python3-matplotlib")


def main():
    options = arguments_of(sys.argv[1:])
    try:
        records = runs.Records(options.out / "records.jsonl", say, options.retry)
        program = runs.Program(options.program.resolve(), options.scene.resolve(), options.out.resolve(),
                               options.preset, options.flags, options.downscale)
        check_comparable(records, program)
        left_out, interrupted = 0, False
        try:
            left_out = measure(options, program, records)
        except KeyboardInterrupt:
            interrupted = True
            say("broken off; what has ended is kept, and the same command goes on")
        if left_out:
            say(f"{left_out} runs are left out for the budget; the same command goes on with them")
        tell(options, program, records)
    except (runs.Failed, ValueError, OSError) as error:
        sys.exit(f"tradeoff.py: {error}")
    sys.exit(130 if interrupted else 0)


if __name__ == "__main__":
    main()
