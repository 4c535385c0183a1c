#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Checks that every #include follows the allowed dependencies of docs/architecture.md.

A room is a folder, or a single header, with its own list of rooms that it may include.

  tools/check_layers.py              checks this source tree
  tools/check_layers.py --graph ROOM prints the dependency layers ("floors") of the rooms in ROOM, from their includes
  tools/check_layers.py --self_test  checks that one planted violation of each kind is reported
"""
import pathlib
import re
import sys
import tempfile

# ALLOWED lists for each room the other rooms that it may include, with their subfolders. A file belongs to the room
# with the longest matching prefix. A header that lower rooms include, such as the interface between problems and the
# engine, is its own room.
KERNELS = ["kernels/math", "kernels/core"]
DRAWN = "kernels/gaussian_splatting/"
INTERNAL = "solver/internal"
CONTRACT = ["solver/problem.h", "solver/problem_interfaces.h", "solver/linear_operator.h", "solver/reduced_system.h"]
PROBLEM = "problems/gaussian_splatting/"
SPLATS = "splatting/"
TRAIN = SPLATS + "train/"
CAMERAS = SPLATS + "cameras/"


def splat_rooms():
    """The rooms of the splatting application, lowest first: each may include the rooms named, all of them lower."""
    base = [*KERNELS, "kernels/ranks", "kernels/image", "kernels/gaussian_splatting", "solver", PROBLEM[:-1]]
    rooms = {
        "points": "",
        "io/bytes": "",
        "io/images": "io/bytes",
        "io/splats": "io/bytes io/images",
        "io/scenes": "points io/bytes io/images io/splats",
        "adam": "",
        "density": "",
        "render": "",
        "distributed": "density",
        "evaluate": "distributed",
        "pruning": "distributed",
        "cameras/unknowns": "",
        "cameras/derivatives": "cameras/unknowns",
        "cameras/alignment": "cameras/unknowns cameras/derivatives evaluate",
        "cameras/training": "cameras/unknowns cameras/derivatives cameras/alignment adam",
        "cameras/joint": "cameras/unknowns cameras/derivatives",
        "memory": "adam density evaluate pruning cameras",
        "train/settings": "adam density pruning cameras/unknowns memory",
        "train/session": "train/settings cameras/unknowns distributed evaluate memory",
        "train/forecast": "train/settings train/session adam density pruning",
        "train/adam_stage": "train/settings train/session train/forecast adam density distributed evaluate pruning cameras "
                            "memory",
        "train/lm_stage": "train/settings train/session cameras distributed evaluate memory",
        "train": "train adam cameras density distributed evaluate memory pruning",
    }
    return {SPLATS + room: [SPLATS + below for below in lower.split()] + base for room, lower in rooms.items()}


def app_rooms():
    """The same for the rooms of the program."""
    base = ["kernels", "solver", "problems", "splatting"]
    rooms = {
        "cli": "",
        "device": "cli",
        "inputs": "cli device",
        "settings": "cli device inputs",
        "usage": "cli settings",
        "render": "cli inputs",
        "doctor": "",
        "reconstruct": "cli",
        "report": "cli inputs settings",
        "viewer": "cli inputs report",
        "training": "cli device doctor inputs settings report viewer",
        "commands": "cli device inputs settings usage render doctor reconstruct report viewer training",
    }
    return {"apps/" + room: ["apps/" + below for below in lower.split()] + base for room, lower in rooms.items()}


ALLOWED = {
    "kernels/math": [],
    "kernels/core": ["kernels/math"],
    "kernels/ranks": KERNELS,
    "kernels/mpi": ["kernels/ranks", *KERNELS],
    "kernels/image": KERNELS,
    "kernels/image/pixel_penalty.h": ["kernels/image", *KERNELS],
    DRAWN + "lenses": KERNELS,
    DRAWN + "formulas": [DRAWN + "lenses", *KERNELS],
    DRAWN + "projection": [DRAWN + "lenses", DRAWN + "formulas", *KERNELS],
    DRAWN + "tiles": [DRAWN + "formulas", DRAWN + "projection", *KERNELS],
    DRAWN + "raster": [DRAWN + "formulas", DRAWN + "projection", DRAWN + "tiles", "kernels/image/pixel_penalty.h", *KERNELS],
    DRAWN + "cache": [DRAWN + "formulas", DRAWN + "tiles", DRAWN + "raster", *KERNELS],
    DRAWN + "view": [DRAWN + below for below in ("formulas", "projection", "tiles", "raster", "cache")] + KERNELS,
    DRAWN + "device": [DRAWN + below for below in ("formulas", "projection", "tiles", "raster", "cache", "view")] + KERNELS,
    "solver": [INTERNAL, *CONTRACT, *KERNELS],
    "solver/problem.h": KERNELS,
    "solver/problem_interfaces.h": ["solver/problem.h", *KERNELS],
    "solver/linear_operator.h": KERNELS,
    "solver/reduced_system.h": ["solver/problem.h", "solver/problem_interfaces.h", "solver/linear_operator.h", *KERNELS],
    INTERNAL: ["solver", *KERNELS],
    INTERNAL + "/linear": ["solver/linear_operator.h", *KERNELS],
    INTERNAL + "/normal_equations": [INTERNAL + "/linear", *CONTRACT, *KERNELS],
    INTERNAL + "/trust_region": KERNELS,
    INTERNAL + "/blocks": [INTERNAL + "/linear", INTERNAL + "/normal_equations", *CONTRACT, *KERNELS],
    INTERNAL + "/reduced": [INTERNAL + "/blocks", INTERNAL + "/linear", INTERNAL + "/sparse_cholesky", *CONTRACT, *KERNELS],
    INTERNAL + "/sparse_cholesky": [INTERNAL + "/blocks", INTERNAL + "/linear", INTERNAL + "/normal_equations",
                                    *CONTRACT, *KERNELS],
    "solver/distributed": ["solver", "kernels/ranks", *KERNELS],
    INTERNAL + "/instantiate": ["solver", *KERNELS],
    "solver/ceres": ["solver", *KERNELS],
    "problems/toy": ["solver", *KERNELS],
    "problems/bundle_adjustment": ["solver", *KERNELS],
    "problems/pose_graph": ["solver", *KERNELS],
    "problems/program": ["solver", INTERNAL + "/small", *KERNELS],
    PROBLEM + "scene": ["kernels/gaussian_splatting", "kernels/ranks", *KERNELS],
    PROBLEM + "model": [PROBLEM + "scene", "kernels/gaussian_splatting", "kernels/image", "kernels/ranks", *KERNELS],
    PROBLEM + "lm": [PROBLEM + "scene", PROBLEM + "model", "solver", "kernels/gaussian_splatting", "kernels/image",
                     "kernels/ranks", *KERNELS],
    **splat_rooms(),
    **app_rooms(),
    "apps": ["apps", "splatting", "problems", "solver", "kernels"],
    "python": ["python", "splatting", "problems", "solver", "kernels"],
    "demo": ["splatting", "problems", "kernels"],
    "bench": ["apps", "splatting", "problems", "solver", "kernels"],
    "tests": ["demo", "bench", "apps", "splatting", "problems", "solver", "kernels"],
}
# The host-and-device macro, which every room may include.
OPEN_HEADERS = {"kernels/core/hd.h"}
# Internal headers that public headers of the engine may include, for templates and members.
NEEDED = {
    "solver/autodiff_manifold.h": ["derivative_passes.h"],
    "solver/block_problem.h": ["blocks/block_structure.h", "normal_equations/preconditioner.h", "normal_equations/step_cost.h"],
    "solver/bounds.h": ["normal_equations/problem_adaptor.h"],
    "solver/cost_function.h": ["autodiff_blocks.h", "derivative_passes.h", "functor_call.h"],
    "solver/device_functors.cuh": ["functor_call.h"],
    "solver/dynamic_autodiff_cost.h": ["autodiff_blocks.h", "functor_call.h"],
    "solver/levenberg_marquardt.h": ["batched_system.h", "lm_decisions.h"],
    "solver/lm_options.h": ["normal_equations/normal_system.h", "trust_region/step_control.h"],
    "solver/residual_blocks.h": ["derivative_passes.h", "functor_call.h", "residual_block_layout.h", "residual_block_rows.h"],
    "solver/small_solver.h": ["small/small_loop.h"],
    "solver/summary.h": ["linear/pcg.h"],
}
# External headers (or prefixes), and the rooms that may include them; bench and tests may include all.
EXTERNAL = {
    "ceres/": ["solver/ceres"],
    "glog/": ["apps", "solver/ceres"],
    "gflags/": ["apps", "demo"],
    "tbb/": ["kernels/core"],
    "thread": ["kernels/core", "kernels/mpi", "apps/viewer"],
    "httplib.h": ["apps/viewer"],
    "future": ["kernels/core"],
    "execution": [],
    "jpeglib.h": [SPLATS + "io/images"],
    "jerror.h": [SPLATS + "io/images"],
    "png.h": [SPLATS + "io/images"],
    "tiffio.h": [SPLATS + "io/images"],
    "webp/": [SPLATS + "io/images"],
    "nanoflann": [PROBLEM + "model"],
    "mpi.h": ["kernels/mpi"],
    "zstd.h": [SPLATS + "io/bytes"],
    "zip.h": [SPLATS + "io/bytes"],
    "zlib.h": [SPLATS + "io/bytes", TRAIN + "session"],
}
SOURCES = {".h", ".cpp", ".inl", ".cu", ".cuh"}
INCLUDE = re.compile(r'^\s*#\s*include\s*(?:"([^"]+)"|<([^>]+)>)')


def room_of(path):
    inside = [room for room in ALLOWED if path == room or path.startswith(room + "/")]
    return max(inside, key=len, default=None)


def fault(room, quoted, angled):
    """Returns the reason why a file of this room may not have this include, or None."""
    if quoted:
        target = room_of(quoted)
        if target is None:
            return f'"{quoted}" is in no room: write include paths relative to the root of the repository'
        seen = [room, *ALLOWED[room]]
        # Only programs may include the Ceres bridge.
        inside = any(target == s or target.startswith(s + "/") for s in seen)
        bridge = target == "solver/ceres" and room not in ("solver/ceres", "apps", "bench", "tests")
        if (not inside or bridge) and quoted not in OPEN_HEADERS:
            return f"{room} may not include {target}"
    elif room not in ("bench", "tests"):
        for prefix, rooms in EXTERNAL.items():
            if (angled == prefix or prefix[-1] in "/n" and angled.startswith(prefix)) and not any(
                    room == allowed or room.startswith(allowed + "/") for allowed in rooms):
                return f"{room} may not include <{angled}>"
    return None


def needless(name, quoted):
    """Returns the reason why a public header of the engine may not include this internal header, or None."""
    inside = quoted and quoted.startswith(INTERNAL + "/") and quoted.removeprefix(INTERNAL + "/")
    if inside and name.startswith("solver/") and name.count("/") == 1 and inside not in NEEDED.get(name, []):
        return f"a public header may not include {quoted} unless NEEDED lists it"
    return None


def namesake(included, quoted):
    """Returns the reason why a file may not include this header, or None: it has included one with the same base name."""
    other = included.setdefault(quoted.rsplit("/", 1)[-1], quoted) if quoted else quoted
    return None if other == quoted else f'"{quoted}" and "{other}" have the same base name: rename one'


def faults_in(root):
    """Returns the number of files read, and one line for each fault."""
    files = [p for top in sorted({room.split("/")[0] for room in ALLOWED}) for p in sorted((root / top).rglob("*"))
             if p.suffix in SOURCES]
    found = []
    for file in files:
        name = file.relative_to(root).as_posix()
        room = room_of(name)
        if room is None:
            found.append(f"{name}: is in no known room; add its room to {pathlib.Path(__file__).name}")
            continue
        included = {}  # base name -> path
        for number, line in enumerate(file.read_text(encoding="utf-8").splitlines(), 1):
            match = INCLUDE.match(line)
            why = match and (fault(room, *match.groups()) or needless(name, match.group(1)) or
                             namesake(included, match.group(1)))
            if why:
                found.append(f"{name}:{number}: {why}")
    return len(files), found


def draw(root, top):
    """Prints the rooms in `top` by layer: each is above the rooms that it includes. Returns 1 if there is a cycle."""
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
    print(f"rooms in cycles: {len(rest)}")
    return 1 if rest or not uses else 0


def self_test():
    planted = {
        "kernels/math/a.h": '#include "kernels/core/span.h"',
        "kernels/core/b.cpp": '#include "solver/problem.h"',
        "kernels/image/c.h": '#include "kernels/gaussian_splatting/formulas/project.h"',
        "kernels/gaussian_splatting/tiles/c.h": '#include "kernels/gaussian_splatting/raster/passes.h"',
        "solver/d.h": '#include "kernels/image/ssim.h"',
        "solver/e.cpp": "#include <ceres/ceres.h>",
        "solver/f.h": '#include "solver/internal/linear/pcg.h"',
        "solver/internal/linear/m.h": '#include "solver/problem.h"',
        "solver/internal/normal_equations/n.h": '#include "solver/lm_options.h"',
        "problems/toy/f.h": '#include "kernels/gaussian_splatting/formulas/project.h"',
        "problems/toy/g.h": '#include "problems/gaussian_splatting/scene/scene.h"',
        "problems/gaussian_splatting/lm/h.h": '#include "splatting/adam/adam.h"',
        "splatting/io/splats/h.cpp": '  #  include "apps/cli/flags.h"',
        "problems/gaussian_splatting/lm/i.cpp": "#include <thread>",
        "problems/gaussian_splatting/model/j.cpp": '#include "camera.h"',
        "splatting/adam/m.h": '#include "splatting/train/settings/train_options.h"',
        "splatting/train/session/m.h": '#include "splatting/train/adam_stage/adam_stage.h"',
        "apps/cli/k.cpp": '#include "apps/viewer/viewer.h"',
        "apps/k.cpp": '#include "tests/support/scene.h"',
        "problems/l.cpp": "",
        "apps/m.cpp": '#include "splatting/adam/options.h"\n#include "splatting/density/options.h"',
    }
    sound = {
        "kernels/math/ok.h": '#include "kernels/core/hd.h"\n#include <cmath>',
        "solver/problem.h": '#include "kernels/core/span.h"',
        "solver/internal/normal_equations/ok.h": '#include "solver/internal/linear/pcg.h"\n#include "solver/problem.h"',
        "solver/summary.h": '#include "solver/internal/linear/pcg.h"',
        "solver/internal/ok.h": '#include "solver/internal/normal_equations/ok.h"',
        "solver/ceres/ok.cpp": '#include <ceres/ceres.h>\n#include "solver/problem.h"',
        "problems/gaussian_splatting/model/ok.cpp": '#include "kernels/image/ssim.h"\n#include <nanoflann.hpp>',
        "apps/viewer/ok.cpp": '#include "apps/cli/print.h"\n#include <glog/logging.h>\n#include <httplib.h>',
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
    print("\n".join(found) if found else f"layers: {count} files, every include is allowed")
    return 1 if found or count == 0 else 0


if __name__ == "__main__":
    sys.exit(main())
