# shellcheck shell=bash disable=SC2034,SC2154
# Shared by ./run, ./test and .ci/run (sourced): packages, configuring, building. Needs `root`, the repository's folder.
# Everything said here goes to standard error.

run_packages=(g++ cmake ninja-build nlohmann-json3-dev libcli11-dev libfmt-dev libmuparser-dev libmeshoptimizer-dev libboost-dev libmd-dev
              libpugixml-dev libnauty2-dev graphviz gnuplot-nox)
learning_packages=(libtorch-dev libopenblas0-pthread)
mip_packages=(coinor-libcbc-dev)
python_packages=(python3-dev pybind11-dev python3-numpy)
mpi_packages=(libopenmpi-dev openmpi-bin)
cad_packages=(libocct-data-exchange-dev libocct-ocaf-dev libassimp-dev)
test_packages=("${run_packages[@]}" "${learning_packages[@]}" "${mip_packages[@]}" "${cad_packages[@]}" "${mpi_packages[@]}" "${python_packages[@]}" libgtest-dev libbenchmark-dev python3
               coinor-cbc python3-scipy python3-jsonschema python3-yaml python3-pydot python3-lxml clang-format-14
               python3-networkx python3-setuptools python3-pip python3-venv mypy)
# For the tests of the report page. Node and npm may be there from elsewhere, whose packages exclude Debian's.
command -v node >/dev/null || test_packages+=(nodejs)
command -v npm >/dev/null || test_packages+=(npm)
command -v chromium >/dev/null || test_packages+=(chromium)

die() {
  printf 'orasp: %s\n' "$*" >&2
  exit 40
}

# Runs a command: its output is shown as it comes on a terminal, and otherwise only if it fails.
quietly() {
  local log status=0
  if [[ -t 2 ]]; then
    "$@" </dev/null >&2 || return
    return 0
  fi
  log=$(mktemp)
  "$@" </dev/null >"$log" 2>&1 || status=$?
  ((status == 0)) || cat "$log" >&2
  rm -f "$log"
  return "$status"
}

# Installs those of the named Debian packages that are missing.
install_packages() {
  local missing=() name installed sudo=()
  if ! command -v dpkg-query >/dev/null; then
    for name in g++ cmake ninja; do
      command -v "$name" >/dev/null || die "this is not Debian: please install what docs/dependencies.md lists ($name is missing)"
    done
    return
  fi
  installed=" $(dpkg-query -W -f '${Package}/${db:Status-Status} ' "$@" 2>/dev/null || true)"
  for name in "$@"; do
    [[ $installed == *" $name/installed "* ]] || missing+=("$name")
  done
  ((${#missing[@]})) || return 0
  if ((EUID != 0)); then
    command -v sudo >/dev/null ||
      die "missing packages, and neither root nor sudo to install them: apt-get install ${missing[*]}"
    sudo=(sudo)
    [[ -t 0 ]] || sudo=(sudo -n)
  fi
  printf 'orasp: installing %s\n' "${missing[*]}" >&2
  local apt=("${sudo[@]}" env DEBIAN_FRONTEND=noninteractive apt-get -q -y -o Acquire::Retries=3 -o DPkg::Lock::Timeout=300)
  quietly "${apt[@]}" update || printf 'orasp: apt-get update failed; trying with the package lists at hand\n' >&2
  quietly "${apt[@]}" install --no-install-recommends "${missing[@]}" ||
    die "could not install the packages: apt-get install ${missing[*]}"
}

# configured PRESET: does its build folder hold a configured build of this very tree (and not of one it was copied from)?
configured() {
  [[ -e $root/build/$1/build.ninja ]] &&
    grep -qxF "CMAKE_HOME_DIRECTORY:INTERNAL=$root" "$root/build/$1/CMakeCache.txt"
}

# configure PRESET [CMAKE ARGUMENTS]
configure() {
  configured "$1" || rm -rf "${root:?}/build/$1"
  (cd "$root" && cmake --preset "$@")
}

# build_release: installs what is missing, builds everything into build/release, and compiles each header alone.
build_release() {
  install_packages "${test_packages[@]}"
  mkdir -p "$root/build"
  exec 9>"$root/build/lock"
  flock 9
  printf 'orasp: building %s\n' "$root/build/release" >&2
  quietly configure release || die "the build could not be configured"
  quietly cmake --build --preset release --target all all_verify_interface_header_sets || die "the build failed"
  exec 9>&-
}
