# SPDX-License-Identifier: Apache-2.0
"""bench/gpu/run.sh and pack.sh without a GPU: a dry run with mock programs instead of a build.

Usage: gpu_run_test.py PROGRAM     PROGRAM: any program with shared libraries, for pack.sh to collect"""
import json
import os
import pathlib
import shutil
import subprocess
import sys
import tarfile
import tempfile
import unittest

GPU = pathlib.Path(__file__).resolve().parents[2] / "bench" / "gpu"
PROGRAMS = ["tests/device_math_test", "tests/cuda_backend_test", "tests/cuda_engine_test", "tests/cuda_splat_test",
            "tests/cuda_training_test", "bench/gpu_kernels"]
ORDER = ["gpu", "sanitizer", "device_math", "backend", "engine", "splat", "training", "gpu_kernels"]
TOOLS = ["memcheck", "racecheck", "synccheck"]
LINKED_PROGRAM = sys.argv.pop(1) if len(sys.argv) > 1 else None

# Logs its call and the number of steps so far. On request it fails, hangs or reports no GPU.
STAND_IN = """#!/usr/bin/env bash
name=$(basename "$0")
rows=$(grep -c '"step"' "$OUT/summary.json" 2>/dev/null)
echo "${rows:-0} $name $*" >>"$CALLS"
if [[ $* == *--probe* && -e $CALLS.no_gpu ]]; then echo 'no "driver"'; exit 3; fi
if [[ -e $CALLS.fail_$name ]]; then echo "it broke"; exit 5; fi
if [[ $* == *--probe* ]]; then echo 'Stand-in "GPU"'; fi
json=""
while (($#)); do
  if [[ $1 == --json ]]; then json=$2; fi
  shift
done
if [[ -n $json ]]; then echo '{"rows": [{"pass": "J v", "ms": 1.5}]}' >"$json"; fi
"""
SANITIZER = """#!/usr/bin/env bash
echo "sanitizer $*" >>"$CALLS"
if [[ -e $CALLS.no_sanitizer ]]; then echo "not supported here"; exit 0; fi
shift 4
"$@" || exit
echo "========= ERROR SUMMARY: 0 errors"
"""
# Ends a program as `timeout` does after the time limit.
TIMEOUT = """#!/usr/bin/env bash
[[ $1 == -k ]] || exit 99
shift 3
if [[ -e $CALLS.hang_$(basename "$1") && $* != *--probe* ]]; then exit 124; fi
"$@"
"""


def write_program(path, text):
    path.parent.mkdir(parents=True, exist_ok=True)
    path.write_text(text)
    path.chmod(0o755)


class Folder:
    """A build made of mock programs, and a function to run the script on it."""

    def __init__(self, path):
        self.path, self.out, self.calls, self.build = path, path / "out", path / "calls", path / "a build"
        for program in PROGRAMS:
            write_program(self.build / program, STAND_IN)
        write_program(path / "bin" / "compute-sanitizer", SANITIZER)
        write_program(path / "bin" / "timeout", TIMEOUT)

    def run(self, *arguments, script=GPU / "run.sh", **environment):
        env = {**os.environ, "OUT": str(self.out), "CALLS": str(self.calls),
               "PATH": f"{self.path / 'bin'}:{os.environ['PATH']}"}
        env.pop("VESTA_REQUIRE_CUDA", None)
        return subprocess.run(["bash", str(script), *map(str, arguments)], capture_output=True, text=True, cwd="/",
                              env={**env, **environment}, check=False)

    def plant(self, what):
        pathlib.Path(f"{self.calls}.{what}").touch()

    def summary(self):
        return json.loads((self.out / "summary.json").read_text())

    def steps(self):
        return {row["step"]: row["result"] for row in self.summary()["rows"]}


class WithFolder(unittest.TestCase):
    def setUp(self):
        folder = tempfile.TemporaryDirectory()
        self.addCleanup(folder.cleanup)
        self.folder = Folder(pathlib.Path(folder.name))


class WhereAllPasses(unittest.TestCase):
    """One run, in a moved folder that pack.sh made."""

    @classmethod
    def setUpClass(cls):
        folder = tempfile.TemporaryDirectory()
        cls.addClassCleanup(folder.cleanup)
        cls.folder = Folder(pathlib.Path(folder.name))
        for program in PROGRAMS:
            shutil.copy(LINKED_PROGRAM, cls.folder.build / program)
        packed, moved = cls.folder.path / "packed", cls.folder.path / "moved"
        subprocess.run(["bash", str(GPU / "pack.sh"), str(cls.folder.build), str(packed)], check=True,
                       capture_output=True)
        packed.rename(moved)
        cls.libraries = [f.name for f in (moved / "lib").iterdir()]
        for program in PROGRAMS:
            write_program(moved / program, STAND_IN)
        cls.process = cls.folder.run(script=moved / "run.sh")
        cls.calls = cls.folder.calls.read_text().splitlines()

    def test_leaves_few_files(self):
        folder = self.folder
        self.assertEqual(self.process.returncode, 0, self.process.stdout + self.process.stderr)
        self.assertEqual(sorted(f.name for f in folder.out.iterdir()), ["logs.tar.gz", "summary.json", "table.txt"])
        summary, steps = folder.summary(), folder.steps()
        self.assertEqual(set(steps.values()), {"passed"})
        self.assertEqual(list(steps)[: len(ORDER)], ORDER)
        self.assertIs(summary["passed"], True)
        self.assertEqual(summary["gpu"], 'Stand-in "GPU"')
        self.assertEqual(summary["gpu_kernels"]["rows"], [{"pass": "J v", "ms": 1.5}])
        table = (folder.out / "table.txt").read_text()
        self.assertTrue(all(step in table for step in steps))
        self.assertTrue(self.process.stdout.endswith(table))
        with tarfile.open(folder.out / "logs.tar.gz") as logs:
            names = {pathlib.Path(name).name[:-4] for name in logs.getnames() if name.endswith(".log")}
        self.assertEqual(names, set(steps))

    def test_the_packed_folder_has_its_libraries(self):
        self.assertTrue(any(name.startswith("libstdc++") for name in self.libraries), self.libraries)
        self.assertFalse(any(name.startswith(("libc.", "libm.", "ld-")) for name in self.libraries), self.libraries)

    def test_tools_reach_every_kernel(self):
        self.assertIn("--probe", next(c for c in self.calls if c.startswith("sanitizer")), "the tool is tried first")
        for tool in TOOLS:
            calls = [c for c in self.calls if c.startswith("sanitizer") and f"--tool {tool} " in c and "--probe" not in c]
            self.assertEqual(len(calls), 2)
            self.assertTrue(all("--error-exitcode" in call for call in calls))
            # Reductions, and every kernel of views, caches, Adam, density and evaluation.
            for program in ["cuda_backend_test", "cuda_splat_test"]:
                self.assertTrue(any(program in c and "filter" not in c for c in calls))

    def test_the_summary_is_rewritten_after_each_step(self):
        rows = [int(c.split()[0]) for c in self.calls if not c.startswith("sanitizer")]
        self.assertEqual(rows, list(range(len(rows))))

    def test_limits_leave_room(self):
        steps = [line.split() for line in self.folder.run("--list").stdout.splitlines()]
        self.assertEqual([name for name, _ in steps], list(self.folder.steps()))
        script = (GPU / "run.sh").read_text()
        grace = int(next(line for line in script.splitlines() if line.startswith("grace=")).split("=")[1])
        self.assertIn('timeout -k "$grace" "$limit"', script)
        self.assertLessEqual(sum(int(limit) + grace for _, limit in steps), 540)


class WhereSomethingIsAmiss(WithFolder):
    def test_no_gpu_is_a_failure_where_one_is_required(self):
        self.folder.plant("no_gpu")
        self.assertEqual(self.folder.run(self.folder.build).returncode, 1)
        summary, steps = self.folder.summary(), self.folder.steps()
        self.assertEqual(steps.pop("gpu"), "no GPU, and one was required")
        self.assertEqual(set(steps.values()), {"skipped: no GPU"})
        self.assertEqual((summary["gpu"], summary["passed"]), ('none: no "driver"', False))
        self.assertEqual(self.folder.calls.read_text().count("\n"), 1, "nothing else is run")
        self.assertEqual(self.folder.run(self.folder.build, VESTA_REQUIRE_CUDA="0").returncode, 0)
        self.assertEqual(self.folder.steps()["gpu"], "no GPU")

    def test_the_other_steps_are_run_all_the_same(self):
        for what in ["fail_cuda_backend_test", "hang_gpu_kernels", "no_sanitizer"]:
            self.folder.plant(what)
        self.assertEqual(self.folder.run(self.folder.build).returncode, 1)
        steps = self.folder.steps()
        self.assertEqual(steps["backend"], "FAILED (5)")
        self.assertEqual(steps["gpu_kernels"], "stopped after 150 s")
        self.assertEqual(steps["splat"], "passed")
        self.assertIsNone(self.folder.summary()["gpu_kernels"])
        # A tool that runs but detects no fault is no failure, but its result is not used.
        self.assertEqual(steps["sanitizer"], "does not work here (0)")
        self.assertEqual({steps[s] for s in steps if "check." in s}, {"skipped: no compute-sanitizer that works"})

    def test_says_what_to_do_without_programs(self):
        script = self.folder.path / "run.sh"
        script.write_text((GPU / "run.sh").read_text().replace("/usr/local/cuda/bin", "/nonexistent"))
        run = self.folder.run(self.folder.path / "none", script=script)
        self.assertEqual(run.returncode, 2)
        self.assertIn("pack.sh", run.stderr)
        self.assertFalse(self.folder.out.exists())


if __name__ == "__main__":
    unittest.main()
