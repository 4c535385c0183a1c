#!/usr/bin/env python3
"""Checks that the arrows of docs/architecture.md hold in every #include.

  tools/check_layers.py              checks the tree this script lies in
  tools/check_layers.py --graph ROOM draws the floors of the rooms beneath ROOM, by the includes there are
  tools/check_layers.py --self_test  plants one violation of each kind in a made-up tree and expects the report
"""
import pathlib
import re
import sys
import tempfile

# The rooms of the splatting trainer, from the ground up: each may include those named, all below it.
SPLATS = "problems/gaussian_splatting/"
SPLAT_ROOMS = {
    SPLATS + room: [SPLATS + below for below in rooms] +
    ["solver", "kernels/math", "kernels/core", "kernels/ranks", "kernels/image", "kernels/gaussian_splatting"]
    for room, rooms in {
        "model": [],
        "io": ["model"],
        "adam": ["model"],
        "density": ["model"],
        "lm": ["model"],
        "distributed": ["model", "lm"],
        "evaluate": ["model", "distributed"],
        "cameras": ["model", "adam", "evaluate", "lm"],
        "memory": ["model", "adam", "cameras", "density", "lm", "evaluate", "parsimony"],
        "parsimony": ["model", "distributed"],
        "render": ["model"],
        "train": ["model", "adam", "cameras", "density", "distributed", "lm", "evaluate", "memory", "parsimony"],
    }.items()
}
# Room -> rooms it may include, itself apart. The longest matching prefix decides which room a file is in. A header that
# rooms beneath its own see, as the contract between problems and the solver is, is a room of its own.
ALLOWED = {
    "kernels/math": [],
    "kernels/core": ["kernels/math"],
    "kernels/ranks": ["kernels/math", "kernels/core"],
    "kernels/mpi": ["kernels/ranks", "kernels/math", "kernels/core"],
    "kernels/image": ["kernels/math", "kernels/core"],
    "kernels/image/pixel_penalty.h": ["kernels/image", "kernels/math", "kernels/core"],
    "kernels/gaussian_splatting": ["kernels/image/pixel_penalty.h", "kernels/math", "kernels/core"],
    "solver": ["kernels/math", "kernels/core"],
    "solver/problem.h": ["kernels/math", "kernels/core"],
    "solver/problem_interfaces.h": ["solver/problem.h", "kernels/math", "kernels/core"],
    "solver/internal": ["solver/linear", "solver/normal_equations", "solver/problem.h", "solver/problem_interfaces.h",
                        "kernels/math", "kernels/core"],
    "solver/linear": ["kernels/math", "kernels/core"],
    "solver/normal_equations": ["solver/internal", "solver/linear", "solver/problem.h", "solver/problem_interfaces.h",
                                "kernels/math", "kernels/core"],
    "solver/trust_region": ["kernels/math", "kernels/core"],
    "solver/blocks": ["solver/linear", "solver/normal_equations", "solver/problem.h", "kernels/math", "kernels/core"],
    "solver/sparse_cholesky": ["solver/blocks", "solver/linear", "solver/normal_equations", "solver/problem.h",
                               "kernels/math", "kernels/core"],
    "solver/distributed": ["solver", "kernels/ranks", "kernels/math", "kernels/core"],
    "solver/instantiate": ["solver", "kernels/math", "kernels/core"],
    "solver/ceres": ["solver", "kernels/math", "kernels/core"],
    "problems/toy": ["solver", "kernels/math", "kernels/core"],
    "problems/bundle_adjustment": ["solver", "kernels/math", "kernels/core"],
    "problems/deconvolution": ["solver", "kernels/math", "kernels/core"],
    **SPLAT_ROOMS,
    "problems/pose_graph": ["solver", "kernels/math", "kernels/core"],
    "apps": ["problems", "solver", "kernels"],
    "apps/viewer": ["apps", "problems", "solver", "kernels"],
    "bench": ["apps", "problems", "solver", "kernels"],
    "tests": ["bench", "apps", "problems", "solver", "kernels"],
}
# One header below its room: the host-and-device macro, which the formulas need and which needs nothing.
OPEN_HEADERS = {"kernels/core/hd.h"}
# External header (prefix) -> the rooms that may include it; bench and tests may include anything.
EXTERNAL = {
    "ceres/": ["solver/ceres"],
    "glog/": ["apps", "solver/ceres"],
    "gflags/": ["apps"],
    "tbb/": ["kernels/core"],
    "thread": ["kernels/core", "kernels/mpi", "apps/viewer"],
    "httplib.h": ["apps/viewer"],
    "future": ["kernels/core"],
    "execution": [],
    "jpeglib.h": [SPLATS + "io"],
    "jerror.h": [SPLATS + "io"],
    "png.h": [SPLATS + "io"],
    "tiffio.h": [SPLATS + "io"],
    "webp/": [SPLATS + "io"],
    "nanoflann": [SPLATS + "model"],
    "mpi.h": ["kernels/mpi"],
    "zlib.h": [SPLATS + "io", SPLATS + "train"],
}
SOURCES = {".h", ".cpp", ".inl", ".cu", ".cuh"}
INCLUDE = re.compile(r'^\s*#\s*include\s*(?:"([^"]+)"|<([^>]+)>)')


def room_of(path):
    inside = [room for room in ALLOWED if path == room or path.startswith(room + "/")]
    return max(inside, key=len, default=None)


def fault(room, quoted, angled):
    """Why a file of this room may not have this include, or None."""
    if quoted:
        target = room_of(quoted)
        if target is None:
            return f'"{quoted}" names no room: write includes from the root of the repository'
        seen = [room, *ALLOWED[room]]
        # A room that is listed opens the rooms under it too, save that the bridge to Ceres is for programs only.
        inside = any(target == s or target.startswith(s + "/") for s in seen)
        bridge = target == "solver/ceres" and room not in ("solver/ceres", "apps", "bench", "tests")
        if (not inside or bridge) and quoted not in OPEN_HEADERS:
            return f"{room} may not include {target}"
    elif room not in ("bench", "tests"):
        for prefix, rooms in EXTERNAL.items():
            if (angled == prefix or prefix[-1] in "/n" and angled.startswith(prefix)) and room not in rooms:
                return f"{room} may not include <{angled}>"
    return None


def faults_in(root):
    """(number of files read, one line for each fault)"""
    files = [p for top in sorted({room.split("/")[0] for room in ALLOWED}) for p in sorted((root / top).rglob("*"))
             if p.suffix in SOURCES]
    found = []
    for file in files:
        name = file.relative_to(root).as_posix()
        room = room_of(name)
        if room is None:
            found.append(f"{name}: lies in no known room; add its room to {pathlib.Path(__file__).name}")
            continue
        for number, line in enumerate(file.read_text(encoding="utf-8").splitlines(), 1):
            match = INCLUDE.match(line)
            why = match and fault(room, *match.groups())
            if why:
                found.append(f"{name}:{number}: {why}")
    return len(files), found


def draw(root, top):
    """Prints the rooms beneath `top` floor by floor, each above all that it includes; returns the arrows back up."""
    uses = {room: set() for room in ALLOWED if room.startswith(top + "/")}
    lines = dict.fromkeys(uses, 0)
    for file in sorted((root / top).rglob("*")):
        room = room_of(file.relative_to(root).as_posix())
        if file.suffix not in SOURCES or room not in uses:
            continue
        for line in file.read_text(encoding="utf-8").splitlines():
            lines[room] += 1
            match = INCLUDE.match(line)
            target = match and match.group(1) and room_of(match.group(1))
            if target in uses and target != room:
                uses[room].add(target)
    floors, rest = [], dict(uses)
    while rest:
        floor = [room for room in rest if not rest[room] - set().union(*floors, set())]
        if not floor:
            break
        floors.append(floor)
        for room in floor:
            del rest[room]
    for number, floor in reversed(list(enumerate(floors, 1))):
        for room in floor:
            below = ", ".join(sorted(target.split("/")[-1] for target in uses[room]))
            print(f"floor {number}  {room.split('/')[-1]:<10}{lines[room]:>6} lines" + (f"  <- {below}" if below else ""))
    print(f"arrows back up: {len(rest)}")
    return 1 if rest or not uses else 0


def self_test():
    planted = {
        "kernels/math/a.h": '#include "kernels/core/span.h"',
        "kernels/core/b.cpp": '#include "solver/problem.h"',
        "kernels/image/c.h": '#include "kernels/gaussian_splatting/formulas/project.h"',
        "solver/d.h": '#include "kernels/image/ssim.h"',
        "solver/e.cpp": "#include <ceres/ceres.h>",
        "solver/linear/m.h": '#include "solver/problem.h"',
        "solver/normal_equations/n.h": '#include "solver/lm_options.h"',
        "problems/toy/f.h": '#include "kernels/gaussian_splatting/formulas/project.h"',
        "problems/toy/g.h": '#include "problems/gaussian_splatting/camera.h"',
        "problems/gaussian_splatting/io/h.cpp": '  #  include "apps/cli/flags.h"',
        "problems/gaussian_splatting/lm/i.cpp": "#include <thread>",
        "problems/gaussian_splatting/model/j.cpp": '#include "camera.h"',
        "problems/gaussian_splatting/adam/m.h": '#include "splatting/train/settings/options.h"',
        "apps/k.cpp": '#include "tests/support/scene.h"',
        "problems/l.cpp": "",
    }
    sound = {
        "kernels/math/ok.h": '#include "kernels/core/hd.h"\n#include <cmath>',
        "solver/problem.h": '#include "kernels/core/span.h"',
        "solver/normal_equations/ok.h": '#include "solver/internal/linear/pcg.h"\n#include "solver/problem.h"',
        "solver/ok.h": '#include "solver/normal_equations/ok.h"',
        "solver/ceres/ok.cpp": '#include <ceres/ceres.h>\n#include "solver/problem.h"',
        "problems/gaussian_splatting/model/ok.cpp": '#include "kernels/image/ssim.h"\n#include <nanoflann.hpp>',
        "tests/solver/ok_test.cpp": '#include "apps/cli/flags.h"\n#include <ceres/ceres.h>',
    }
    with tempfile.TemporaryDirectory() as folder:
        root = pathlib.Path(folder)
        for name, text in {**planted, **sound}.items():
            (root / name).parent.mkdir(parents=True, exist_ok=True)
            (root / name).write_text(text + "\n")
        _, found = faults_in(root)
    reported = {line.split(":")[0] for line in found}
    if reported != set(planted):
        print("self-test: missed", sorted(set(planted) - reported), "wrongly reported", sorted(reported - set(planted)))
        return 1
    print(f"self-test: all {len(planted)} planted violations reported, nothing else")
    return 0


def main():
    if sys.argv[1:] == ["--self_test"]:
        return self_test()
    if sys.argv[1:2] == ["--graph"]:
        return draw(pathlib.Path(__file__).resolve().parent.parent, sys.argv[2])
    count, found = faults_in(pathlib.Path(__file__).resolve().parent.parent)
    print("\n".join(found) if found else f"layers: {count} files, every include follows the arrows")
    return 1 if found or count == 0 else 0


if __name__ == "__main__":
    sys.exit(main())
