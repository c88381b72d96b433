#!/usr/bin/env python3
"""Checks which folder includes which (docs/architecture.md): arrows point one way.

    tools/check_layers.py              check the tree that this script lies in
    tools/check_layers.py --self-test  show that each rule fails on a planted violation

A "public header" is a header of src/orasp outside the folders named detail and those of INTERNAL.
"""
import re
import sys
import tempfile
from pathlib import Path

# The folders of src/orasp, from the ground up -> the folders that each may include. A file of src/orasp itself (catalogue,
# method_options, orasp) is a folder of its own here.
LAYERS = {
    "model": {"model"},
    # Checks what planners claim, so it shares nothing with them; of the model, see MODEL_OF_CERTIFICATES too.
    "certificate": {"model", "certificate"},
    "containers": {"containers"},
    "task": {"model", "task"},
    "bounds": {"model", "containers", "bounds"},
    "symmetry": {"model", "containers", "symmetry"},
    "graph": {"model", "containers", "task", "bounds", "symmetry", "graph"},
    "planners": {"model", "containers", "task", "bounds", "symmetry", "graph", "planners"},
    "cluster": {"model", "containers", "task", "bounds", "symmetry", "planners", "cluster"},
    "mip": {"model", "containers", "task", "planners", "mip"},
    "explain": {"model", "containers", "task", "bounds", "symmetry", "graph", "planners", "explain"},
    "execution": {"model", "task", "graph", "planners", "execution"},
    "learning": {"model", "containers", "task", "bounds", "planners", "learning"},
    "fleet": {"model", "containers", "task", "mip", "fleet"},
    "geometry": {"model", "containers", "task", "geometry"},
    "io": {"model", "task", "certificate", "mip", "explain", "learning", "fleet", "geometry", "io"},
    "drawing": {"model", "task", "graph", "io", "drawing"},
    "report": {"model", "task", "bounds", "graph", "planners", "explain", "fleet", "io", "report"},
    "catalogue": {"model", "task", "symmetry", "planners", "mip", "execution", "learning", "fleet", "catalogue", "method_options"},
    "catalogue_table": {"model", "task", "bounds", "symmetry", "graph", "planners", "mip", "execution", "learning", "fleet", "catalogue"},
    # What a row of the catalogue says of its options; the two make one.
    "method_options": {"model", "bounds", "symmetry", "catalogue", "method_options"},
    "orasp": {"model", "task", "bounds", "symmetry", "graph", "planners", "cluster", "mip", "explain", "execution", "learning", "fleet", "geometry", "io",
              "drawing", "certificate", "catalogue", "method_options"},
}
# Folders that are not for those who use the library, as are those named detail.
INTERNAL = {"containers"}
# What every folder may include.
GROUND = {"orasp/model/error.h", "orasp/model/index.h", "orasp/model/connection_set.h"}
# What certificates are checked with, of the model: its data, and how plans are checked. Not its rules and rewards for planning.
MODEL_OF_CERTIFICATES = {f"orasp/model/{name}.h" for name in ("problem", "plan_check", "tolerance", "detail/checked_reward",
                                                             "detail/wording")}
# Folders that use the library -> may they include its internal folders?
USERS = {"cli": False, "python": False, "benchmarks": False, "examples": False, "fuzz": True, "tests": True}

# First component of an included path -> the files that may include it. Nothing else is allowed.
IO_INSIDE = r"src/orasp/(io|drawing|report)/(.*\.cpp|(.*/)?detail/.*)"
THIRD_PARTY = {
    "nlohmann": rf"{IO_INSIDE}|(cli|tests|benchmarks)/.*",
    "fmt": rf"{IO_INSIDE}|src/orasp/(catalogue|method_options)\.cpp|(cli|python|tests|benchmarks)/.*",
    "pybind11": r"python/src/.*",
    "meshoptimizer.h": r"src/orasp/report/part_shapes\.cpp",
    "muParser.h": r"src/orasp/io/.*\.cpp",
    "minizip": r"src/orasp/geometry/detail/package_3mf\.cpp",
    "pugixml.hpp": r"src/orasp/io/formats/(.*\.cpp|detail/.*)|src/orasp/geometry/detail/package_3mf\.cpp",
    "sha256.h": r"src/orasp/io/.*\.cpp|tests/.*",
    "boost": r"src/orasp/(graph/graph_size|explain/alternatives)\.cpp|tests/.*",
    "torch": r"src/orasp/learning/.*\.cpp",
    "ATen": r"src/orasp/learning/.*\.cpp",
    **{name: r"src/orasp/mip/mip_solver_cbc\.cpp" for name in (
        "CbcEventHandler.hpp", "CbcModel.hpp", "CbcSolver.hpp", "ClpEventHandler.hpp", "ClpSimplex.hpp",
        "CoinPackedMatrix.hpp", "OsiClpSolverInterface.hpp")},
    "nauty": r"src/orasp/symmetry/automorphisms_nauty\.cpp",
    "mpi.h": r"src/orasp/cluster/ranks_mpi\.cpp",
    "assimp": r"src/orasp/geometry/mesh_reader_assimp\.cpp",
    "CLI": r"cli/options/command_line\.cpp",
    "gtest": r"tests/.*",
    "gmock": r"tests/.*",
    "benchmark": r"benchmarks/.*",
}
# OpenCASCADE: a thousand headers that end alike.
OPENCASCADE = r"src/orasp/geometry/(cad_reader_occt\.cpp|detail/occt_shape\.(h|cpp))"
# The operating system and the processor: anywhere but in the model and in public headers.
PLATFORM = {"sys", "dlfcn.h", "unistd.h", "fcntl.h", "link.h", "malloc.h", "poll.h", "pthread.h", "sched.h", "signal.h", "spawn.h", "termios.h",
            "immintrin.h"}

INCLUDE = re.compile(r'^\s*#\s*include\s*([<"])([^>"]+)[>"]')


def layer_of(path):
    """The layer of a path below src/orasp: its folder, or the file's name where there is none."""
    return path.split("/")[0].split(".")[0]


def is_internal(path):
    """Whether `path`, which begins with "orasp/", is not for those who use the library."""
    return "/detail/" in path or path.split("/")[1] in INTERNAL


def fault(file, bracket, target):
    """Why `file` (relative to the root) may not include `target`, or None."""
    folder = file.split("/")[0]
    in_library = file.startswith("src/orasp/")
    layer = layer_of(file[len("src/orasp/"):]) if in_library else folder
    public_header = in_library and file.endswith(".h") and not is_internal(file[len("src/"):])

    if target.startswith("orasp/"):
        if bracket == "<":
            return 'write it as #include "orasp/..."'
        if not in_library:
            return None if USERS[folder] or not is_internal(target) else f"{folder} may include public headers only"
        if target in GROUND:
            return None
        wanted = layer_of(target[len("orasp/"):])
        if layer == "certificate" and wanted == "model" and target not in MODEL_OF_CERTIFICATES:
            return f"certificate may not include {target}"
        return None if wanted in LAYERS[layer] else f"{layer} may not include {wanted}"
    if bracket == '"':
        if in_library:
            return 'inside the library every quoted include begins with "orasp/"'
        own = "/" not in target or target.startswith(f"{folder}/")
        return None if own else f"{folder} may include the library and its own files only"

    first = target.split("/")[0]
    if first in THIRD_PARTY:
        return None if re.fullmatch(THIRD_PARTY[first], file) else f"{first} may not be included here"
    if target.endswith(".hxx"):
        return None if re.fullmatch(OPENCASCADE, file) else f"{target} may not be included here"
    if first in PLATFORM:
        return f"{target} may not be included here" if layer == "model" or public_header else None
    if re.fullmatch(r"[a-z0-9_]+", target):
        return None  # a standard header
    return f"{target} is neither a standard header nor in the table THIRD_PARTY of tools/check_layers.py"


def check(root):
    """All faults of the tree below `root`, as lines."""
    faults = []
    for top in ["src/orasp", *USERS]:
        for path in sorted((root / top).rglob("*")):
            if path.suffix not in (".h", ".cpp"):
                continue
            file = path.relative_to(root).as_posix()
            if file.startswith("src/orasp/") and layer_of(file[len("src/orasp/"):]) not in LAYERS:
                faults.append(f"{file}: this folder is in no layer")
                continue
            for number, line in enumerate(path.read_text(encoding="utf-8").splitlines(), 1):
                match = INCLUDE.match(line)
                why = match and fault(file, match[1], match[2])
                if why:
                    faults.append(f"{file}:{number}: {line.strip()}: {why}")
    return faults


ALLOWED = [
    ("src/orasp/model/a.h", "<vector>"),
    ("src/orasp/model/a.cpp", '"orasp/model/b.h"'),
    ("src/orasp/planners/a.h", '"orasp/model/b.h"'),
    ("src/orasp/certificate/a.cpp", '"orasp/model/plan_check.h"'),
    ("src/orasp/io/a.cpp", '"orasp/certificate/b.h"'),
    ("src/orasp/planners/a.cpp", '"orasp/containers/b.h"'),
    ("src/orasp/containers/a.cpp", '"orasp/model/error.h"'),
    ("src/orasp/planners/a.cpp", "<sys/resource.h>"),
    ("src/orasp/graph/graph_size.cpp", "<boost/multiprecision/cpp_int.hpp>"),
    ("src/orasp/io/a.cpp", "<nlohmann/json.hpp>"),
    ("src/orasp/io/detail/a.h", "<nlohmann/json.hpp>"),
    ("src/orasp/io/a.cpp", "<muParser.h>"),
    ("src/orasp/io/formats/graphml.cpp", "<pugixml.hpp>"),
    ("src/orasp/io/formats/detail/a.h", "<pugixml.hpp>"),
    ("src/orasp/io/a.cpp", '"orasp/task/result.h"'),
    ("src/orasp/learning/dqn.cpp", "<torch/torch.h>"),
    ("src/orasp/mip/mip_solver_cbc.cpp", "<CbcModel.hpp>"),
    ("src/orasp/geometry/cad_reader_occt.cpp", "<BRep_Tool.hxx>"),
    ("src/orasp/geometry/mesh_reader_assimp.cpp", "<assimp/scene.h>"),
    ("src/orasp/cluster/ranks_mpi.cpp", "<mpi.h>"),
    ("src/orasp/cluster/a.cpp", '"orasp/planners/b.h"'),
    ("src/orasp/io/import_files.cpp", '"orasp/geometry/mesh.h"'),
    ("src/orasp/learning/dqn.h", '"orasp/task/result.h"'),
    ("src/orasp/catalogue.cpp", '"orasp/learning/dqn.h"'),
    ("src/orasp/orasp.h", '"orasp/catalogue.h"'),
    ("cli/options/command_line.cpp", "<CLI/CLI.hpp>"),
    ("cli/solve.cpp", '"cli/solve.h"'),
    ("cli/solve.cpp", '"orasp/catalogue.h"'),
    ("python/src/a.cpp", "<pybind11/pybind11.h>"),
    ("python/src/a.cpp", '"bindings.h"'),
    ("python/src/a.cpp", '"orasp/orasp.h"'),
    ("tests/a.cpp", '"orasp/containers/b.h"'),
    ("tests/a.cpp", "<gtest/gtest.h>"),
]
PLANTED = [
    ("src/orasp/model/a.h", '"orasp/planners/b.h"'),
    ("src/orasp/model/a.cpp", '"orasp/io/b.h"'),
    ("src/orasp/certificate/a.cpp", '"orasp/model/transition_system.h"'),
    ("src/orasp/certificate/a.cpp", '"orasp/bounds/piece_gains.h"'),
    ("src/orasp/certificate/a.cpp", '"orasp/planners/a.h"'),
    ("src/orasp/certificate/a.cpp", '"orasp/graph/a.h"'),
    ("src/orasp/planners/a.cpp", '"orasp/certificate/a.h"'),
    ("src/orasp/model/a.cpp", "<fmt/format.h>"),
    ("src/orasp/model/a.cpp", "<unistd.h>"),
    ("src/orasp/containers/a.cpp", '"orasp/model/problem.h"'),
    ("src/orasp/graph/a.cpp", '"orasp/planners/b.h"'),
    ("src/orasp/planners/a.cpp", '"orasp/io/b.h"'),
    ("src/orasp/planners/a.cpp", '"orasp/learning/b.h"'),
    ("src/orasp/planners/a.cpp", '"orasp/catalogue.h"'),
    ("src/orasp/planners/a.cpp", "<boost/multiprecision/cpp_int.hpp>"),
    ("src/orasp/graph/graph_size.h", "<boost/multiprecision/cpp_int.hpp>"),
    ("src/orasp/planners/a.h", "<sys/resource.h>"),
    ("src/orasp/io/a.h", "<nlohmann/json.hpp>"),
    ("src/orasp/io/a.h", "<nlohmann/json_fwd.hpp>"),
    ("src/orasp/io/a.h", "<fmt/format.h>"),
    ("src/orasp/io/a.h", "<muParser.h>"),
    ("src/orasp/io/a.cpp", '"orasp/catalogue.h"'),
    ("src/orasp/io/a.cpp", '"orasp/planners/b.h"'),
    ("src/orasp/io/a.cpp", '"b.h"'),
    ("src/orasp/io/a.cpp", "<orasp/model/b.h>"),
    ("src/orasp/io/a.cpp", "<pugixml.hpp>"),
    ("src/orasp/io/formats/graphml.h", "<pugixml.hpp>"),
    ("src/orasp/learning/a.cpp", '"orasp/io/b.h"'),
    ("src/orasp/learning/dqn.h", "<torch/torch.h>"),
    ("src/orasp/catalogue.cpp", "<torch/torch.h>"),
    ("src/orasp/mip/mip.cpp", "<CbcModel.hpp>"),
    ("src/orasp/geometry/contacts.cpp", "<gp_Pnt.hxx>"),
    ("src/orasp/geometry/cad_reader_occt.cpp", "<assimp/scene.h>"),
    ("src/orasp/geometry/mesh.cpp", '"orasp/io/b.h"'),
    ("src/orasp/cluster/ranks.cpp", "<mpi.h>"),
    ("src/orasp/planners/a.cpp", '"orasp/cluster/b.h"'),
    ("src/orasp/catalogue.h", "<fmt/format.h>"),
    ("src/orasp/utils/a.h", "<vector>"),
    ("cli/main.cpp", "<CLI/CLI.hpp>"),
    ("cli/solve.cpp", '"orasp/containers/b.h"'),
    ("cli/solve.cpp", '"tests/a.h"'),
    ("benchmarks/a.cpp", '"orasp/containers/b.h"'),
    ("examples/consumer/main.cpp", '"orasp/containers/b.h"'),
    ("python/src/a.cpp", '"orasp/containers/b.h"'),
    ("python/src/a.cpp", '"cli/options/problem_source.h"'),
    ("src/orasp/io/a.cpp", "<pybind11/pybind11.h>"),
    ("tests/a.cpp", "<CLI/CLI.hpp>"),
]


def self_test():
    """The number of cases in which check() says the wrong thing."""
    wrong = 0
    for cases, expected in ((ALLOWED, 0), (PLANTED, 1)):
        for file, include in cases:
            with tempfile.TemporaryDirectory() as folder:
                path = Path(folder) / file
                path.parent.mkdir(parents=True)
                path.write_text(f"#pragma once\n#  include {include}  // planted\n", encoding="utf-8")
                found = check(Path(folder))
            if len(found) != expected:
                wrong += 1
                print(f"{file} with {include}: expected {expected} faults, found {found}")
    print(f"{len(ALLOWED)} allowed and {len(PLANTED)} planted includes, {wrong} judged wrongly")
    return wrong


def main():
    if sys.argv[1:] == ["--self-test"]:
        return 1 if self_test() else 0
    if sys.argv[1:]:
        print(__doc__)
        return 2
    faults = check(Path(__file__).resolve().parent.parent)
    print("\n".join(faults) if faults else "every include obeys the layers")
    return 1 if faults else 0


if __name__ == "__main__":
    sys.exit(main())
