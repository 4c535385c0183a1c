# SPDX-License-Identifier: Apache-2.0
"""bench/gpu/pack.sh on a CUDA build: after moving the folder, its programs run and find all shared libraries in it,
except those of the C library. Needs no GPU.

Usage: pack_test.py BUILD"""
import os
import pathlib
import subprocess
import sys
import tempfile

build = pathlib.Path(sys.argv[1])
root = pathlib.Path(__file__).resolve().parents[2]
with tempfile.TemporaryDirectory() as folder:
    packed, moved = pathlib.Path(folder) / "packed", pathlib.Path(folder) / "moved"
    subprocess.run(["bash", root / "bench" / "gpu" / "pack.sh", build, packed], check=True)
    packed.rename(moved)
    environment = {"PATH": os.environ["PATH"], "OUT": str(pathlib.Path(folder) / "out"), "VESTA_REQUIRE_CUDA": "0"}
    of_the_machine = ("libc.", "libm.", "libdl.", "librt.", "libpthread.", "libcuda.")
    for program in sorted([*(moved / "tests").iterdir(), moved / "bench" / "gpu_kernels"]):
        lines = subprocess.run(["ldd", program], check=True, capture_output=True, text=True, env=environment).stdout
        for line in lines.splitlines():
            name, _, path = line.strip().partition(" => ")
            if path and not name.startswith(of_the_machine):
                assert path.startswith(str(moved / "tests" / "..")) or path.startswith(str(moved)), line
        flag = ["--probe", "yes"] if program.name == "gpu_kernels" else ["--gtest_list_tests"]
        run = subprocess.run([program, *flag], capture_output=True, text=True, env=environment, cwd="/", check=False)
        assert run.returncode in (0, 3), (program, run.returncode, run.stderr)
    # Without a GPU the script ends after its first step.
    probe = subprocess.run([moved / "bench" / "gpu_kernels", "--probe", "yes"], env=environment, check=False)
    if probe.returncode == 3:
        run = subprocess.run(["bash", moved / "run.sh"], capture_output=True, text=True, env=environment, cwd="/",
                             check=False)
        assert run.returncode == 0 and "skipped: no GPU" in run.stdout, run.stdout + run.stderr
