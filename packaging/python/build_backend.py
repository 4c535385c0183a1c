# SPDX-License-Identifier: Apache-2.0
"""Builds the wheel for pip (PEP 517): compiles the extension module with CMake, and packs it with the Python sources.

Environment: JOBS sets the number of compile jobs.
"""
import base64
import hashlib
import os
import re
import subprocess
import sys
import sysconfig
import tempfile
import zipfile
from pathlib import Path

ROOT = Path(__file__).resolve().parents[2]


def _field(name):
    return re.search(rf'^{name} = "(.*)"$', (ROOT / "pyproject.toml").read_text(), re.MULTILINE)[1]


def _tag():
    python = f"cp{sys.version_info.major}{sys.version_info.minor}"
    return f"{python}-{python}-{re.sub(r'[-.]', '_', sysconfig.get_platform())}"


def _metadata():
    return (f"Metadata-Version: 2.1\nName: {_field('name')}\nVersion: {_field('version')}\n"
            f"Summary: {_field('description')}\nLicense: Apache-2.0\nRequires-Python: {_field('requires-python')}\n"
            f"Requires-Dist: numpy>=1.21\n")


def _compile(folder):
    build = ROOT / "build" / "wheel"
    generator = [] if (build / "CMakeCache.txt").exists() else ["-G", "Ninja"]
    subprocess.run(["cmake", "-S", ROOT, "-B", build, *generator, "-DCMAKE_BUILD_TYPE=Release", "-DVESTA_PYTHON=ON",
                    f"-DVESTA_PYTHON_DIR={folder}", f"-DPython_EXECUTABLE={sys.executable}", "-DVESTA_BUILD_TESTS=OFF",
                    "-DVESTA_BUILD_APPS=OFF", "-DVESTA_BUILD_BENCHMARKS=OFF", "-DVESTA_CERES_BRIDGE=OFF",
                    "-DVESTA_INSTALL=OFF", "-DCMAKE_UNITY_BUILD=ON"], check=True)
    subprocess.run(["cmake", "--build", build, "--target", "vesta_python", "--parallel",
                    os.environ.get("JOBS", str(os.cpu_count()))], check=True)


def get_requires_for_build_wheel(config_settings=None):
    return []


def build_wheel(wheel_directory, config_settings=None, metadata_directory=None):
    name = f"{_field('name')}-{_field('version')}"
    wheel = f"{name}-{_tag()}.whl"
    with tempfile.TemporaryDirectory() as folder:
        _compile(folder)
        files = {str(path.relative_to(folder)): path.read_bytes()
                 for path in sorted(Path(folder).rglob("*")) if path.is_file() and "__pycache__" not in path.parts}
    info = f"{name}.dist-info"
    files[f"{info}/METADATA"] = _metadata().encode()
    files[f"{info}/WHEEL"] = f"Wheel-Version: 1.0\nGenerator: vesta\nRoot-Is-Purelib: false\nTag: {_tag()}\n".encode()
    files[f"{info}/LICENSE"] = (ROOT / "LICENSE").read_bytes()
    record = "".join(f"{file},sha256={base64.urlsafe_b64encode(hashlib.sha256(data).digest()).rstrip(b'=').decode()},"
                     f"{len(data)}\n" for file, data in files.items())
    files[f"{info}/RECORD"] = f"{record}{info}/RECORD,,\n".encode()
    with zipfile.ZipFile(Path(wheel_directory) / wheel, "w", zipfile.ZIP_DEFLATED) as archive:
        for file, data in files.items():
            archive.writestr(file, data)
    return wheel
