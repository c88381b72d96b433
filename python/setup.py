"""Builds the package with CMake, for `pip install --no-build-isolation ./python` (docs/python.md).

Everything that it needs is in Debian: no network. The library is built in build/wheel, or in the folder that the environment
variable ORASP_BUILD names, as it is configured there.
"""
import os
import re
import subprocess
import sys
from pathlib import Path

from setuptools import Extension, setup
from setuptools.command.build_ext import build_ext

HERE = Path(__file__).resolve().parent
ROOT = HERE.parent
VERSION = re.search(r"project\(orasp VERSION (\S+)", (ROOT / "CMakeLists.txt").read_text(encoding="utf-8"))[1]


class BuildWithCMake(build_ext):
    """Makes orasp._orasp, and the modules that it opens when they are needed, by the build of the whole project."""

    def build_extension(self, extension):
        target = Path(self.get_ext_fullpath(extension.name)).resolve()
        build = Path(os.environ.get("ORASP_BUILD", ROOT / "build" / "wheel"))
        if not (build / "CMakeCache.txt").exists():
            self.configure(build)
        jobs = os.environ.get("CMAKE_BUILD_PARALLEL_LEVEL", str(os.cpu_count() or 1))
        subprocess.run(["cmake", "--build", build, "--target", "python_package", "-j", jobs], check=True)
        target.parent.mkdir(parents=True, exist_ok=True)
        for file in (build / "python" / "orasp").glob("*.so"):
            if file.exists():
                (target.parent / file.name).write_bytes(file.read_bytes())

    @staticmethod
    def configure(build):
        subprocess.run(["cmake", "-S", ROOT, "-B", build, "-G", "Ninja", "-D", "CMAKE_BUILD_TYPE=Release", "-D", "ORASP_UNITY=ON",
                        "-D", "ORASP_BUILD_TESTS=OFF", "-D", "ORASP_WITH_PYTHON=ON", "-D", f"Python_EXECUTABLE={sys.executable}"],
                       check=True)


setup(
    name="orasp",
    version=VERSION,
    description="The best order in which robots put a product together or take it apart, with proof",
    packages=["orasp"],
    package_data={"orasp": ["py.typed", "*.pyi"]},
    ext_modules=[Extension("orasp._orasp", sources=[])],
    cmdclass={"build_ext": BuildWithCMake},
    python_requires=">=3.9",
    install_requires=["numpy"],
    zip_safe=False,
)
