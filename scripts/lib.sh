# SPDX-License-Identifier: GPL-3.0-only
# Set-up shared by the scripts in this folder; source it under `set -euo pipefail`.
#
#   require_packages PACKAGE...    Debian packages: installs what is missing (root) or says how
#   packages_for PURPOSE...        their names: build library core plugin volumes gui benchmarks python pymeshlab
#                                  pictures browser format lint cache slurm meshlab (2020.09, and what its GUI needs without
#                                  a display)
#   require_headers [VERSION]      sets MESHLAB_SOURCE_DIR (the caller's where there is one; default 2025.07)
#   require_meshlab_gui            sets MESHLAB_GUI, MeshLab 2025.07's program, built from its source
#   require_python [PURPOSE]       sets PYTHON, the interpreter of an environment with requirements.txt (or
#                                  requirements-PURPOSE.txt) installed from a wheelhouse, which sets WHEELHOUSE
#   build_preset PRESET [TARGET..] configures where needed, builds; needs the two first
#   use_compiler_cache             builds configured from here on compile nothing twice
#   plugin_path PRESET             where build_preset puts the plugin
#
# All of them are quick when there is nothing to do. Only the cache folder and build/ are written to, beside packages.

project_root=$(cd "$(dirname "${BASH_SOURCE[0]}")/.." && pwd)
cache_dir=${XDG_CACHE_HOME:-$HOME/.cache}/sphere-propagation
without_volumes=${without_volumes-}
callers_source_dir=${MESHLAB_SOURCE_DIR-}

say() { printf '%s\n' "$*" >&2; }
die() { say "error: $*"; exit 1; }

# Logs go to a file and are shown only when the step fails.
logged() { # LOG COMMAND...
  local log=$1; shift
  mkdir -p "$(dirname "$log")"
  if ! "$@" >"$log" 2>&1 </dev/null; then
    tail -n 40 "$log" >&2
    say "failed: $* (whole log: $log)"
    return 1
  fi
}

# One process at a time fills the cache. Usage: with_lock FUNCTION ARG...
with_lock() {
  mkdir -p "$cache_dir"
  if command -v flock >/dev/null; then exec 9>"$cache_dir/lock"; flock 9; fi
  "$@"
  exec 9>&-
}

# A scratch folder in the cache, so that finished things can be moved into place in one step. Call it under the lock.
make_scratch() {
  rm -rf "$cache_dir"/tmp.* # of runs that were killed
  scratch=$(mktemp -d "$cache_dir/tmp.XXXXXX")
  trap 'rm -rf "$scratch"' EXIT
}
drop_scratch() { rm -rf "$scratch"; trap - EXIT; }

# ---------------------------------------------------------------- packages

packages_for() {
  local purpose
  for purpose; do
    case $purpose in
      build)      echo g++ cmake ninja-build ca-certificates xz-utils ;;
      library)    echo libeigen3-dev libnanoflann-dev libboost-dev ;;
      core)       packages_for library; echo libgtest-dev ;;
      plugin)     echo libqt5opengl5-dev libglew-dev ;;
      volumes)    if has_volumes; then echo libinsighttoolkit5-dev; fi ;;
      gui)        echo xvfb libgl1-mesa-dri xdotool ;;
      benchmarks) echo libbenchmark-dev ;;
      python)     if ! have_usable_python; then echo python3-venv; fi ;;
      pymeshlab)  echo libgl1 libopengl0 ;;
      pictures)   echo libegl1 ;;
      browser)    echo chromium ;;
      meshlab)    echo meshlab xvfb xauth libgl1-mesa-dri ;;
      format)     echo clang-format ;;
      cache)      echo ccache ;;
      slurm)      if may_have_slurm; then echo slurm-wlm munge iproute2; fi ;;
      lint)       echo clang-format clang-tidy ;;
      *)          die "packages_for: no purpose '$purpose'" ;;
    esac
  done
}

# Debian's Slurm is not put beside one that is there from elsewhere.
may_have_slurm() {
  local program
  if [ -n "$(is_debian && missing_packages slurmd slurmctld)" ]; then
    for program in slurmctld slurmd sbatch; do ! command -v "$program" >/dev/null || return 1; done
  fi
}

has_volumes() { [ -z "$without_volumes" ] && [ -f "$project_root/filter_label_volume/CMakeLists.txt" ]; }

is_debian() { command -v dpkg-query >/dev/null && command -v apt-get >/dev/null; }

missing_packages() { # PACKAGE...
  local package installed
  installed=$(dpkg-query -W -f='${db:Status-Status} ${Package}\n' "$@" 2>/dev/null || true)
  for package; do
    grep -qxF "installed $package" <<<"$installed" || echo "$package"
  done
}

require_packages() {
  is_debian || { require_commands_elsewhere; return; }
  local missing
  mapfile -t missing < <(missing_packages "$@")
  [ ${#missing[@]} -gt 0 ] || return 0

  if [ "$(id -u)" != 0 ]; then
    say "Packages are missing. An administrator must run:"
    say "  apt-get update && apt-get install -y --no-install-recommends ${missing[*]}"
    exit 1
  fi
  say "Installing packages: ${missing[*]}"
  local log=$cache_dir/logs/apt.log
  # Fresh package lists are fetched only when the ones at hand do not do.
  apt_install "${missing[@]}" >/dev/null 2>&1 && return
  logged "$log" apt-get -q update || die "apt-get update failed"
  logged "$log" apt_install "${missing[@]}" || die "could not install ${missing[*]}"
}

apt_install() {
  DEBIAN_FRONTEND=noninteractive apt-get -q -y -o DPkg::Lock::Timeout=300 install --no-install-recommends "$@" </dev/null
}

# Other systems name their packages differently, so only say what is needed.
say_what_is_needed() {
  say "This is not Debian or a relative, so nothing is installed for you. What is needed:
  build     a C++17 compiler, CMake 3.21 or later, Ninja
  core      Eigen 3.4, nanoflann, Boost (headers of Multiprecision), GoogleTest
  plugin    Qt 5.15 (Core, Widgets, OpenGL, Xml) and GLEW, both with headers
  volumes   ITK 5 (or call scripts/build --without-volumes)
  tests     Python 3.9 to 3.13 with the packages in scripts/requirements.txt; libGL and libOpenGL for PyMeshLab
  pictures  libEGL
  hosts     MeshLab 2020.09, Xvfb and xauth
  headers   fetched with git, or set MESHLAB_SOURCE_DIR to an unpacked MeshLab 2025.07 source tree"
}

require_commands_elsewhere() {
  local command missing=
  for command in c++ cmake ninja python3; do
    command -v "$command" >/dev/null || missing+=" $command"
  done
  if [ -n "$missing" ]; then say_what_is_needed; die "not found:$missing"; fi
}

# ---------------------------------------------------------------- MeshLab's headers

# What is known of a version: Debian suites that have its source package, upstream's tag with its commit, and what to unpack.
meshlab_release() {
  case $1 in
    2025.07) suites="sid forky"
             tag=MeshLab-2025.07 commit=dc48b91ae562756a6988048c5d5c7f1d2b687256
             parts="src/common src/vcglib" submodule=src/vcglib ;;
    2020.09) suites="bookworm"
             tag=Meshlab-2020.09 commit=a595226b8b02505afbf9fd4ffbccbd6011046ae6
             parts="src/common vcglib" submodule=vcglib ;;
    *) die "MeshLab $1 is not known here: set MESHLAB_SOURCE_DIR to an unpacked source tree of it" ;;
  esac
}

known_sha256() {
  case $1 in
    meshlab_2025.07~dfsg.orig.tar.xz)  echo d22c98d362f2a284e481af8dbfc272b2222f5b9c67b3cf8bec57d1c3161886f4 ;;
    meshlab_2020.09+dfsg1.orig.tar.xz) echo d6715352ff65caffdec0292858d4263eb0c3cbbf3b1e5c2e2bab218e3f234630 ;;
  esac
}

is_meshlab_source() {
  [ -f "$1/src/common/ml_document/mesh_document.h" ] || [ -f "$1/src/common/meshmodel.h" ] || return 1
  [ -f "$1/src/vcglib/vcg/complex/complex.h" ] || [ -f "$1/vcglib/vcg/complex/complex.h" ]
}

require_headers() {
  local version=${1:-2025.07}
  if [ -n "$callers_source_dir" ]; then
    MESHLAB_SOURCE_DIR=$(realpath -m "$callers_source_dir")
    is_meshlab_source "$MESHLAB_SOURCE_DIR" ||
      die "MESHLAB_SOURCE_DIR=$MESHLAB_SOURCE_DIR is no MeshLab source tree with src/common and vcglib"
    local found
    found=$(cat "$MESHLAB_SOURCE_DIR/ML_VERSION" 2>/dev/null || echo "$version")
    [ "$found" = "$version" ] || say "warning: MESHLAB_SOURCE_DIR holds MeshLab $found, the plugin is for $version"
  else
    MESHLAB_SOURCE_DIR=$cache_dir/meshlab-$version
    [ -d "$MESHLAB_SOURCE_DIR" ] || with_lock fetch_headers "$version"
  fi
}

fetch_headers() {
  local version=$1 suites tag commit parts submodule
  [ ! -d "$MESHLAB_SOURCE_DIR" ] || return 0 # another process was quicker
  meshlab_release "$version"
  make_scratch
  require_tarball "$version" && unpack_headers || clone_headers ||
    die "Could not get the headers of MeshLab $version. Set MESHLAB_SOURCE_DIR to an unpacked source tree of it."
  is_meshlab_source "$scratch/headers" || die "MeshLab $version was fetched, but lacks src/common or vcglib"
  mv -T "$scratch/headers" "$MESHLAB_SOURCE_DIR"
  drop_scratch
}

# Sets `tarball` to MeshLab's original source in the cache, fetched as Debian's source package.
require_tarball() {
  local version=$1 suite uri
  for tarball in "$cache_dir/sources/meshlab_$version"[~+.]*tar*; do
    if [ -f "$tarball" ]; then return 0; fi
  done
  local key # Debian's relatives do not have it
  for key in /usr/share/keyrings/debian-archive-keyring.{gpg,pgp}; do [ ! -f "$key" ] || break; done
  is_debian && [ -f "$key" ] || return 1
  for uri in $(archive_uris); do
    for suite in $suites; do
      say "Fetching the source package of MeshLab $version ($suite)"
      if download_tarball "$version" "$uri" "$suite" "$key"; then return 0; fi
    done
  done
  return 1
}

# Archives that this machine gets Debian's own releases from, in whatever format its sources are written. A third party's
# archive may be listed too; Debian's signing key sorts it out.
archive_uris() {
  local codename
  codename=$(. /etc/os-release && echo "${VERSION_CODENAME-}")
  mkdir -p "$scratch/no-lists/partial"
  apt-get -o Dir::State::lists="$scratch/no-lists" -o Debug::NoLocking=1 --print-uris update 2>/dev/null |
    sed -nE "s#^'([^']+)/dists/(${codename:-stable}|(old)?stable|testing|unstable|sid)/InRelease'.*#\1#p" |
    awk '!/^cdrom:/ && !seen[$0]++' || true
}

download_tarball() { # VERSION URI SUITE KEYRING; all state in the scratch folder, so a plain user can do it
  local version=$1 package file sum
  local dir=$scratch/apt log=$cache_dir/logs/source-package.log
  rm -rf "$dir"; mkdir -p "$dir/lists/partial" "$dir/cache/archives/partial"
  printf 'deb-src [signed-by=%s] %s %s main\n' "$4" "$2" "$3" >"$dir/sources.list"
  local apt=(-q -o Dir::Etc::SourceList="$dir/sources.list" -o Dir::Etc::SourceParts=- -o Dir::State::Lists="$dir/lists"
             -o Dir::Cache="$dir/cache" -o Debug::NoLocking=1 -o APT::Sandbox::User=root
             -o APT::Default-Release= -o APT::Update::Error-Mode=any)
  mkdir -p "${log%/*}"
  if ! apt-get "${apt[@]}" update >"$log" 2>&1; then
    say "  not to be had: $(grep -E -m 1 '^(E|W|Err):' "$log" || echo "see $log")"
    if grep -q NO_PUBKEY "$log"; then say "  A newer package debian-archive-keyring brings the missing signing key."; fi
    return 1
  fi
  package=$(apt-cache "${apt[@]}" showsrc --only-source meshlab 2>/dev/null |
    sed -nE "s/^Version: ($version[~+.-].*)/\1/p" | tail -n 1)
  if [ -z "$package" ]; then say "  $3 has another version"; return 1; fi
  (cd "$dir" && logged "$log" apt-get "${apt[@]}" source --download-only --tar-only "meshlab=$package") || return 1
  file=$(cd "$dir" && ls meshlab_*.tar.*)
  sum=$(sha256sum "$dir/$file"); sum=${sum%% *}
  case $(known_sha256 "$file") in
    "$sum") ;;
    "") say "note: $file (sha256 $sum) is not a source known here; using it" ;;
    *) say "error: $file has the sha256 $sum, not the known one"; return 1 ;;
  esac
  mkdir -p "$cache_dir/sources"
  tarball=$cache_dir/sources/$file
  mv "$dir/$file" "$tarball"
}

unpack_headers() {
  local part patterns=('*/LICENSE.txt' '*/ML_VERSION')
  for part in $parts; do patterns+=("*/$part"); done
  rm -rf "$scratch/headers"; mkdir "$scratch/headers"
  if ! tar -xf "$tarball" -C "$scratch/headers" --strip-components=1 --wildcards --no-wildcards-match-slash \
       "${patterns[@]}" 2>"$scratch/tar.log"; then
    if ! is_meshlab_source "$scratch/headers"; then
      say "$tarball could not be unpacked: $(tail -n 1 "$scratch/tar.log")"
      rm -f "$tarball"
      return 1
    fi
  fi
}

clone_headers() {
  command -v git >/dev/null || { say "git is needed to fetch MeshLab's headers from its own repository"; return 1; }
  say "Fetching MeshLab's repository ($tag)"
  local to=$scratch/headers log=$cache_dir/logs/clone.log found
  rm -rf "$to"
  export GIT_TERMINAL_PROMPT=0
  logged "$log" git clone -q --depth 1 --branch "$tag" https://github.com/cnr-isti-vclab/meshlab "$to" &&
    logged "$log" git -C "$to" submodule update -q --init --depth 1 "$submodule" || return 1
  found=$(git -C "$to" rev-parse HEAD)
  [ "$found" = "$commit" ] || say "note: the tag $tag is $found now, not $commit as it was; using it"
  rm -rf "$to/.git"
}

# ---------------------------------------------------------------- MeshLab's GUI

# No package has MeshLab 2025.07 for Debian 12: it is built from the same source as the headers, with the plugins named here only.
gui_plugins="io_base filter_create filter_colorproc decorate_base edit_pickpoints"

require_meshlab_gui() {
  MESHLAB_GUI=$cache_dir/meshlab-gui-2025.07/meshlab
  has_meshlab_gui || with_lock build_meshlab_gui
}

has_meshlab_gui() { [ -x "$MESHLAB_GUI" ] && [ -f "${MESHLAB_GUI%/*}/plugins/lib${gui_plugins##* }.so" ]; } # the last one came last

build_meshlab_gui() {
  ! has_meshlab_gui || return 0 # another process was quicker
  local dir=${MESHLAB_GUI%/*} work=${MESHLAB_GUI%/*}.part log=$cache_dir/logs/meshlab-gui.log plugin list=
  [ -f "$work/source/src/meshlab/main.cpp" ] || fetch_gui_source "$work/source"
  say "Building MeshLab 2025.07's GUI (once; about 11 minutes of one core)"
  for plugin in $gui_plugins; do list+=${list:+;}meshlabplugins/$plugin; done
  # Libraries are looked for beside the program, so it can be moved into place when it is finished; a build that was stopped goes on.
  logged "$log" cmake -S "$work/source" -B "$work/build" -G Ninja -DCMAKE_BUILD_TYPE=Release -DCMAKE_BUILD_RPATH_USE_ORIGIN=ON \
    -DMESHLAB_BUILD_MINI=ON -DMESHLAB_ALLOW_OPTIONAL_EXTERNAL_LIBRARIES=OFF -DMESHLAB_PLUGINS="$list" ||
    die "CMake could not configure MeshLab"
  logged "$log" cmake --build "$work/build" --target meshlab copy-distrib-files $gui_plugins || die "the build of MeshLab failed"
  rm -rf "$dir"
  mv -T "$work/build/src/distrib" "$dir"
  rm -rf "$work"
}

fetch_gui_source() { # FOLDER
  meshlab_release 2025.07
  make_scratch
  mkdir "$scratch/source"
  if require_tarball 2025.07; then
    tar -xf "$tarball" -C "$scratch/source" --strip-components=1 || die "$tarball could not be unpacked: remove it and try again"
  else
    clone_headers || die "Could not get the source of MeshLab 2025.07"
    mv -T "$scratch/headers" "$scratch/source"
  fi
  mkdir -p "${1%/*}"
  rm -rf "$1"
  mv -T "$scratch/source" "$1"
  drop_scratch
}

# ---------------------------------------------------------------- Python

# The system's Python first, then whatever is on the path; PyMeshLab has wheels for 3.9 to 3.13.
python_candidates() {
  local name
  for name in /usr/bin/python3 python3 python3.13 python3.12 python3.11 python3.10 python3.9; do
    if command -v "$name" >/dev/null; then echo "$name"; fi
  done
}
python_version() {
  "$1" -c 'import sys; v = sys.version_info[:2]; (3, 9) <= v <= (3, 13) or sys.exit(1); print("%d.%d" % v)' 2>/dev/null
}
can_make_environments() { "$1" -c 'import ensurepip, venv' 2>/dev/null; }

# Sets base_python and python_series where a usable one exists, or one whose environment is complete already.
have_usable_python() {
  [ -z "${base_python-}" ] || return 0
  local candidate
  for candidate in $(python_candidates); do
    python_series=$(python_version "$candidate") || continue
    if environment_is_complete || can_make_environments "$candidate"; then base_python=$candidate; return 0; fi
  done
  return 1
}

environment_is_complete() { # [PURPOSE]
  local dir=$cache_dir/venv-$python_series${1:+-$1}
  cmp -s "$dir/installed.txt" "$project_root/scripts/requirements${1:+-$1}.txt" && [ -x "$dir/bin/python" ]
}

require_python() {
  # Some shells forbid what is compiled to be kept: every process then compiles NumPy again, for a second.
  unset PYTHONDONTWRITEBYTECODE
  have_usable_python || die "No Python 3.9 to 3.13 that can make virtual environments was found (PyMeshLab has wheels for these)."
  environment_is_complete "$@" || with_lock make_environment "$@"
  PYTHON=$cache_dir/venv-$python_series${1:+-$1}/bin/python
  WHEELHOUSE=$cache_dir/wheelhouse-$python_series${1:+-$1}
  export PYTHON WHEELHOUSE
}

make_environment() {
  ! environment_is_complete "$@" || return 0 # another process was quicker
  local name=$python_series${1:+-$1} requirements=$project_root/scripts/requirements${1:+-$1}.txt log=$cache_dir/logs/pip.log
  local dir=$cache_dir/venv-$name wheels=$cache_dir/wheelhouse-$name
  if "$dir/bin/python" -m pip --version >/dev/null 2>&1; then # somebody may be using it
    say "Bringing the Python environment $dir up to date"
  else
    say "Making the Python environment $dir"
    rm -rf "$dir"
    logged "$log" "$base_python" -m venv "$dir" || die "could not make the Python environment"
  fi
  # Wheels are kept: not every package index lets pip cache, and the next environment needs no network.
  if ! cmp -s "$wheels/requirements.txt" "$requirements"; then
    say "Downloading Python packages ($([ -n "${1-}" ] && echo "for the $1" || echo "about 370 MB"), once)"
    rm -rf "$wheels.part"; mkdir -p "$wheels.part"
    local source # --use-pep517: pip 23.0, Debian 12's, else calls setup.py for a command that wheel brings, which is not here
    for source in $(sed -n 's/^# built from source: //p' "$requirements"); do
      logged "$log" "$dir/bin/python" -m pip --disable-pip-version-check wheel -q --use-pep517 --no-deps -w "$wheels.part" "$source" ||
        die "could not build the Python package $source"
    done
    logged "$log" "$dir/bin/python" -m pip --disable-pip-version-check download -q --only-binary :all: -r "$requirements" \
      -d "$wheels.part" --find-links "$wheels.part" $([ ! -d "$wheels" ] || echo --find-links "$wheels") ||
      die "could not download the Python packages"
    cp "$requirements" "$wheels.part/requirements.txt"
    rm -rf "$wheels"
    mv -T "$wheels.part" "$wheels"
  fi
  # Modules are compiled when they are imported first: most never are.
  logged "$log" "$dir/bin/python" -m pip --disable-pip-version-check install -q --no-compile --no-index --find-links "$wheels" \
    -r "$requirements" ||
    die "could not install the Python packages"
  # Without libOpenGL, PyMeshLab imports but lacks the plugin that opens PLY files.
  ! grep -q '^pymeshlab' "$requirements" || "$dir/bin/python" -c 'import pymeshlab, sys; sys.exit(pymeshlab.plugin_number() < 58)' ||
    die "PyMeshLab does not load all its plugins: are libGL.so.1 and libOpenGL.so.0 installed?"
  cp "$requirements" "$dir/installed.txt"
}

# ---------------------------------------------------------------- build

meshlab_version_of() { # PRESET: the MeshLab whose headers it needs
  case $1 in *2020.09) echo 2020.09 ;; *) echo 2025.07 ;; esac
}

plugin_path() { echo "$project_root/build/$1/plugins/libfilter_sphere_propagation.so"; }

build_preset() {
  local preset=$1; shift
  local dir=$project_root/build/$preset volumes=OFF target targets=()
  if has_volumes; then volumes=ON; fi
  for target; do targets+=(--target "$target"); done
  mkdir -p "$dir"
  if command -v flock >/dev/null; then exec 8>"$dir/lock"; flock 8; fi # one build of a preset at a time

  if ! is_configured "$dir" "$volumes"; then
    say "Configuring $preset"
    # Start afresh: a cache remembers what it found, and where the checkout was. No plugin that is left out now stays behind.
    rm -rf "$dir/CMakeCache.txt" "$dir/CMakeFiles" "$dir/plugins"
    if ! logged "$dir/configure.log" cmake -S "$project_root" --preset "$preset" \
         -DMESHLAB_SOURCE_DIR="$MESHLAB_SOURCE_DIR" -DSPHERE_PROPAGATION_VOLUMES=$volumes; then
      is_debian || say_what_is_needed
      die "CMake could not configure the preset $preset"
    fi
    echo "$dir $MESHLAB_SOURCE_DIR $volumes" >"$dir/configured-for"
  fi

  # On a terminal Ninja's one line shows that something moves; elsewhere a line every half a minute does.
  local build=(cmake --build "$dir" ${targets[@]+"${targets[@]}"}) watch= status=0
  if [ ! -t 1 ]; then
    build=(logged "$dir/build.log" "${build[@]}")
    report_progress "$preset" "$dir/build.log" 8>&- & watch=$!
  fi
  "${build[@]}" || status=$?
  if [ -n "$watch" ]; then kill "$watch" 2>/dev/null || true; wait "$watch" 2>/dev/null || true; fi
  exec 8>&-
  [ "$status" -eq 0 ] || die "the build of $preset failed"
}

# What the last line of a build's log says, as long as it changes.
report_progress() { # PRESET LOG
  local line last=
  while sleep 30; do
    line=$(tail -n 1 "$2" 2>/dev/null | cut -c 1-100)
    if [ "$line" != "$last" ]; then say "Building $1: $line"; last=$line; fi
  done
}

# Where there is ccache, and no launcher of the caller's. The library of two presets with the same flags is compiled once.
use_compiler_cache() {
  [ -z "${CMAKE_CXX_COMPILER_LAUNCHER-}" ] && command -v ccache >/dev/null || return 0
  export CMAKE_CXX_COMPILER_LAUNCHER=ccache CCACHE_DIR=$cache_dir/ccache CCACHE_BASEDIR=$project_root CCACHE_NOHASHDIR=1
}

is_configured() {
  [ -f "$1/build.ninja" ] && [ "$1/build.ninja" -nt "$project_root/CMakePresets.json" ] &&
    [ "$(cat "$1/configured-for" 2>/dev/null)" = "$1 $MESHLAB_SOURCE_DIR $2" ]
}
