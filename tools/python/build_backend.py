"""Makes a wheel of the package swept (PEP 517): CMake builds and installs it, and this packs what is installed.

`pip wheel tools/python --no-deps` calls it. SWEPT_CMAKE_ARGS holds further arguments of CMake; SWEPT_BUILD_DIR names a
folder to build in, so that a second wheel is made sooner.
"""

import base64
import hashlib
import os
import pathlib
import re
import shlex
import subprocess
import sys
import sysconfig
import tempfile
import zipfile

ROOT = pathlib.Path(__file__).resolve().parents[2]


def _version():
    text = (ROOT / "CMakeLists.txt").read_text()
    return re.search(r"project\(swept VERSION (\S+)", text).group(1)


def _tag():
    python = "cp%d%d" % sys.version_info[:2]
    return "%s-%s-%s" % (python, python, re.sub(r"[-.]", "_", sysconfig.get_platform()))


def _metadata():
    return (
        "Metadata-Version: 2.1\nName: swept\nVersion: %s\nSummary: Exact motion blur for point clouds\n"
        "License: BSD-3-Clause\nRequires-Python: >=3.9\nRequires-Dist: numpy>=1.20\n" % _version()
    )


def _run(*command):
    subprocess.run(command, check=True, stdout=sys.stderr)


def _install(build, prefix):
    extra = shlex.split(os.environ.get("SWEPT_CMAKE_ARGS", ""))
    _run("cmake", "-S", str(ROOT), "-B", build, "-DCMAKE_BUILD_TYPE=Release", "-DSWEPT_BUILD_TESTS=OFF",
         "-DSWEPT_PYTHON=ON", "-DSWEPT_PYTHON_DIR=python", "-DPython_EXECUTABLE=" + sys.executable, *extra)
    _run("cmake", "--build", build, "--target", "swept_python")
    _run("cmake", "--install", build, "--component", "python", "--prefix", prefix)


def _record(data):
    digest = base64.urlsafe_b64encode(hashlib.sha256(data).digest()).rstrip(b"=").decode()
    return "sha256=%s,%d" % (digest, len(data))


def build_wheel(wheel_directory, config_settings=None, metadata_directory=None):
    info = "swept-%s.dist-info" % _version()
    name = "swept-%s-%s.whl" % (_version(), _tag())
    with tempfile.TemporaryDirectory() as work:
        build = os.environ.get("SWEPT_BUILD_DIR") or os.path.join(work, "build")
        _install(build, os.path.join(work, "prefix"))
        package = pathlib.Path(work, "prefix", "python", "swept")
        files = {"swept/" + path.name: path.read_bytes() for path in sorted(package.iterdir()) if path.is_file()}
    files[info + "/METADATA"] = _metadata().encode()
    files[info + "/WHEEL"] = (
        "Wheel-Version: 1.0\nGenerator: swept\nRoot-Is-Purelib: false\nTag: %s\n" % _tag()).encode()
    files[info + "/LICENSE"] = (ROOT / "LICENSE").read_bytes()
    record = "".join("%s,%s\n" % (path, _record(data)) for path, data in files.items())
    files[info + "/RECORD"] = (record + info + "/RECORD,,\n").encode()
    with zipfile.ZipFile(os.path.join(wheel_directory, name), "w", zipfile.ZIP_DEFLATED) as wheel:
        for path, data in files.items():
            entry = zipfile.ZipInfo(path)
            entry.external_attr = 0o644 << 16
            entry.compress_type = zipfile.ZIP_DEFLATED
            wheel.writestr(entry, data)
    return name


def build_sdist(sdist_directory, config_settings=None):
    raise RuntimeError("Swept has no source distribution of its own: take the repository")
