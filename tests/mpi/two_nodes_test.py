"""Trains the demo's scene in one process and on two nodes (tools/two_nodes.py): the same splat.

two_nodes_test.py SOURCE_DIR VESTA VESTA_DEMO_SCENE; ends with 77 where this machine does not let it make nodes.
"""
import subprocess
import sys
import tempfile
from pathlib import Path


def main(source, vesta, demo_scene):
    with tempfile.TemporaryDirectory() as folder:
        scene, alone, together = (Path(folder) / name for name in ("scene", "alone", "together"))
        subprocess.run([demo_scene, f"--out={scene}", "--views=8", "--width=64", "--height=48"], check=True)
        train = [vesta, "train", str(scene), "--iterations=60", "--set", "adam.views_per_iteration=2", "--threads=1", "--noreport"]
        ended = subprocess.run([sys.executable, Path(source) / "tools" / "two_nodes.py", "--", *train, f"--out={together}"],
                               check=False, timeout=120)
        if ended.returncode != 0:
            return ended.returncode
        subprocess.run([*train, f"--out={alone}"], check=True, timeout=120)
        splats = [(run / "point_cloud.ply").read_bytes() for run in (alone, together)]
        if splats[0] != splats[1]:
            print(f"two nodes came to another splat than one process: {len(splats[1])} for {len(splats[0])} bytes, or other numbers")
            return 1
        return 0


if __name__ == "__main__":
    sys.exit(main(*sys.argv[1:]))
