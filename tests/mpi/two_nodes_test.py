# SPDX-License-Identifier: Apache-2.0
"""Trains the demo's scene in one process and on two nodes and expects the same splat.

two_nodes_test.py link|slurm SOURCE_DIR VESTA VESTA_DEMO_SCENE
  link: tools/two_nodes.py; slurm: tools/two_slurm_nodes.sh, by srun and by mpirun in a batch job
Exit status 77 (skipped) if this machine cannot create nodes.
"""
import subprocess
import sys
import tempfile
from pathlib import Path


def status_of(command, folder):
    """Returns the exit status of a command. After a timeout, terminates it so that it removes its nodes."""
    with subprocess.Popen(command, cwd=folder) as process:
        try:
            return process.wait(timeout=120)
        except subprocess.TimeoutExpired:
            process.terminate()
            raise


def on_linked_nodes(tools, folder, train):
    return status_of([sys.executable, tools / "two_nodes.py", "--", *train], folder)


def by_slurm(tools, folder, train):
    return status_of([tools / "two_slurm_nodes.sh", "srun", "--nodes=2", "--ntasks=2", "--mpi=pmix", *train], folder)


def by_mpirun_under_slurm(tools, folder, train):
    job = folder / "job.sh"
    as_root = "export OMPI_ALLOW_RUN_AS_ROOT=1 OMPI_ALLOW_RUN_AS_ROOT_CONFIRM=1\n"  # only root can create nodes
    job.write_text("#!/bin/sh\n#SBATCH --nodes=2 --ntasks-per-node=1\n" + as_root +
                   " ".join(["exec", "mpirun", *map(str, train)]) + "\n")
    return status_of([tools / "two_slurm_nodes.sh", "sbatch", "--wait", job], folder)


def main(kind, source, vesta, demo_scene):
    ways = {"link": [on_linked_nodes], "slurm": [by_slurm, by_mpirun_under_slurm]}[kind]
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        scene = folder / "scene"
        subprocess.run([demo_scene, f"--out={scene}", "--views=8", "--width=64", "--height=48"], check=True)
        train = [vesta, "train", str(scene), "--iterations=60", "--set", "adam.batch_size=2", "--threads=1", "--noreport"]
        splats = []
        for k, way in enumerate(ways):
            status = way(Path(source) / "tools", folder, [*train, f"--out={folder / str(k)}"])
            if status != 0:
                return status
            splats.append((folder / str(k) / "point_cloud.ply").read_bytes())
        subprocess.run([*train, f"--out={folder / 'alone'}"], check=True, timeout=120)
        alone = (folder / "alone" / "point_cloud.ply").read_bytes()
        for splat in splats:
            if splat != alone:
                print(f"two nodes trained another splat: {len(splat)} instead of {len(alone)} bytes, or other numbers")
                return 1
        return 0


if __name__ == "__main__":
    sys.exit(main(*sys.argv[1:]))
