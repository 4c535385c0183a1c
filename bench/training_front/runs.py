"""Runs of `vesta train` and the records of them: a line of JSON each, appended as soon as the run has ended."""
import datetime
import json
import math
import shutil
import subprocess
import time
from pathlib import Path

import report
from training_front import knobs

# What a record has, in figures.
FIGURES = ("seconds", "work", "iterations", "peak_mib", "gaussians", "ply_mib", "psnr", "ssim", "cost", "wall_s")


class Failed(Exception):
    """A run that ended without a result: what the program said, in a line."""


def identity(record):
    """Two runs of one identity are the same run."""
    return json.dumps([record["scene"], record["flags"], record["options"]], sort_keys=True)


def is_whole(record):
    """Whether a line of the file is a record: of a run that failed, or with all figures."""
    if not isinstance(record, dict) or not isinstance(record.get("options"), dict):
        return False
    if not {knobs.LENGTH, knobs.SEED} <= record["options"].keys() or not isinstance(record.get("flags"), list):
        return False
    if not all(isinstance(record.get(word), str) for word in ("scene", "machine", "commit")):
        return False
    if "failed" in record:
        return True
    return all(isinstance(record.get(figure), (int, float)) and math.isfinite(record[figure]) for figure in FIGURES)


class Records:
    """The records in a file, which is made if missing. What is no record is told to `say`, and run again."""

    def __init__(self, path, say, retry=False):
        """retry: whether runs that failed count as not run."""
        self.path, self.rows, self._retry = path, [], retry
        path.parent.mkdir(parents=True, exist_ok=True)
        text = path.read_text() if path.exists() else ""
        if text and not text.endswith("\n"):  # the line that a killed program was writing
            path.write_text(text + "\n")
        for number, line in enumerate(text.splitlines(), 1):
            try:
                record = json.loads(line)
            except ValueError:
                record = None
            if is_whole(record):
                self.rows.append(record)
            elif line.strip():
                say(f"{path}:{number}: not a record; passed over")

    def names(self):
        """Of what need not be run."""
        return {identity(record) for record in self.rows if not (self._retry and "failed" in record)}

    def of(self, program):
        """The last record of each run of this scene with these flags."""
        like = program.blank({})
        return list({identity(row): row for row in self.rows
                     if all(row[word] == like[word] for word in ("scene", "flags"))}.values())

    def append(self, record):
        with self.path.open("a") as file:
            file.write(json.dumps(record) + "\n")
        self.rows.append(record)


class Program:
    """`vesta` and the scene that it trains."""

    def __init__(self, program, scene, out, preset, flags, downscale):
        """out: a folder for what runs write, emptied of it. downscale: by what images are divided when quality is
        measured."""
        self._program, self._scene, self._folder = program, scene, out / "run"
        self._preset, self._flags, self._downscale = preset, flags, downscale
        options = json.loads(self._call("config", f"--preset={preset}"))["options"]
        # The preset's, but that lengths count; few evaluations on the way, which take time and are not needed.
        self.base = {**knobs.flat(options), "adam.iterations": "auto", knobs.SCALE: downscale, "adam.evaluations": 1}

    def _call(self, *words):
        result = subprocess.run([str(word) for word in (self._program, *words)], capture_output=True, text=True)
        if result.returncode == 130:
            raise KeyboardInterrupt
        if result.returncode != 0:
            lines = result.stderr.strip().splitlines() or [f"{self._program} ended with {result.returncode}"]
            raise Failed(lines[-1])
        return result.stdout

    def blank(self, options):
        """The record of a run that is still to be run."""
        return {"scene": self._scene.name, "preset": self._preset, "flags": self._flags, "options": options,
                "machine": report.machine(), "commit": report.commit()}

    def run(self, options):
        """Trains and measures; returns the record. Where the program fails the record says so."""
        begin = time.monotonic()
        record = self.blank(options)
        try:
            record.update(self._figures(options))
        except Failed as error:
            record["failed"] = str(error)
        finally:
            shutil.rmtree(self._folder, ignore_errors=True)
        return {**record, "wall_s": time.monotonic() - begin,
                "ended": datetime.datetime.now(datetime.timezone.utc).isoformat(timespec="seconds")}

    def _figures(self, options):
        settings = [f"--set={key}={knobs.text_of(value)}" for key, value in options.items() if value is not None]
        self._call("train", self._scene, "--out", self._folder, f"--preset={self._preset}", *settings, *self._flags)
        metrics = json.loads((self._folder / "metrics.json").read_text())
        ply = self._folder / "point_cloud.ply"
        test, cost = metrics["test"], metrics["history"][-1]["cost"]
        if options[knobs.SCALE] != self._downscale:
            measured = self._folder / "eval.json"
            self._call("eval", ply, self._scene, f"--downscale={self._downscale}", "--json", measured)
            evaluation = json.loads(measured.read_text())
            test, cost = evaluation["test"], evaluation["cost"]
        if test["psnr"] is None:
            raise Failed("its PSNR is not finite: the renders are exact, or broken")
        return {"seconds": metrics["seconds"]["total"] - metrics["seconds"]["eval"], "work": metrics["work_megapixels"],
                "iterations": max(row["iteration"] for row in metrics["history"] if row["stage"] == "adam"),
                "peak_mib": metrics["peak_memory_mib"], "gaussians": metrics["gaussians"],
                "ply_mib": ply.stat().st_size / 2**20, "psnr": test["psnr"], "ssim": test["ssim"], "cost": cost,
                "threads": metrics["threads"], "device": metrics["device"]}


class Forecast:
    """Seconds that runs will take, in proportion to their lengths, by what those like them took."""

    def __init__(self, rows):
        self._known = {}  # by what runs have in common but for length and seed; "": of all runs
        for row in rows:
            self.add(row)

    @staticmethod
    def _kind(options):
        return json.dumps({key: value for key, value in options.items() if key not in (knobs.LENGTH, knobs.SEED)},
                          sort_keys=True)

    def add(self, record):
        if "failed" in record:
            return
        for kind in ("", self._kind(record["options"])):
            self._known.setdefault(kind, {})[record["options"][knobs.LENGTH]] = record["wall_s"]

    def seconds(self, options):
        """0 where nothing is known yet."""
        known = self._known.get(self._kind(options)) or self._known.get("")
        if not known:
            return 0
        length = options[knobs.LENGTH]
        like = min(known, key=lambda other: abs(math.log(other / length)))
        return known[like] * length / like


def carry_out(plan, program, records, budget, say, clock=time.monotonic):
    """Runs what has no record yet and adds its record. A run that would end over `budget` seconds from now is left out,
    as far as can be foreseen. Returns how many were, and the seconds that all of it took."""
    begin, known, forecast = clock(), records.names(), Forecast(records.rows)
    left = [options for options in plan if identity(program.blank(options)) not in known]
    left_out = 0
    for number, options in enumerate(left):
        spent = clock() - begin
        if spent >= budget or spent + forecast.seconds(options) > budget:
            left_out += 1
            continue
        record = program.run(options)
        records.append(record)
        forecast.add(record)
        ahead = min(sum(map(forecast.seconds, left[number + 1:])), max(0, budget - (clock() - begin)))
        say(f"[{number + 1}/{len(left)}] {line_of(record, program.base)}; "
            f"{datetime.timedelta(seconds=round(ahead))} left")
    return left_out, clock() - begin


def line_of(record, base):
    options = record["options"]
    what = ", ".join(filter(None, [f"length {options[knobs.LENGTH]:g}", knobs.words_of(knobs.changed(base, options)),
                                   f"seed {options[knobs.SEED]}"]))
    if "failed" in record:
        return f"{what}: FAILED: {record['failed']}"
    return f"{what}: {record['psnr']:.2f} dB, SSIM {record['ssim']:.4f}, {record['seconds']:.1f} s"
