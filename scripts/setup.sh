#!/usr/bin/env bash
# Installs what the project is built from, by name, from the distribution's own archive: Debian 12, Debian 13,
# Ubuntu 24.04. Needs nothing beforehand but bash. Asks no questions, says what it does, and does nothing when nothing is
# missing.
#
#   scripts/setup.sh           install what is missing (as root, or through sudo)
#   scripts/setup.sh --check   list what is missing; exit 1 if anything is
#   scripts/setup.sh --help
set -euo pipefail

packages=(
  # tools
  git make g++ cmake ninja-build pkg-config ccache python3
  # checks and fuzzing
  clang clang-format libclang-rt-dev
  # the library
  libeigen3-dev libtbb-dev libfmt-dev nlohmann-json3-dev libfast-float-dev libnanoflann-dev libgdal-dev
  libmuparser-dev libproj-dev libpng-dev zlib1g-dev libcairo2-dev fonts-dejavu-core
  # the command line
  libcli11-dev
  # tests and benchmarks
  libgtest-dev libboost-dev libcgal-dev
  # the Python module; what else it is built and tested with comes by pip into an environment (scripts/python_venv)
  python3-dev python3-venv
)

# Debian 12 is the one Debian release without LASzip. The three packages of Debian 13 need nothing newer than Debian 12
# has (libc6 >= 2.34, libstdc++6 >= 11), so they are taken as they are; apt checks that, and the archive's signature.
neighbour=trixie
laszip_packages=(liblaszip-dev liblaszip8 liblaszip-api8)

project=$(cd "$(dirname "${BASH_SOURCE[0]}")/.." && pwd)
laszip_prefix=$project/build/deps/laszip # without root; cmake/FindLASzip.cmake looks there too
keyring=/usr/share/keyrings/debian-archive-keyring.gpg
scratch=

say() { printf 'setup: %s\n' "$*"; }
fail() {
  printf 'setup: %s\n' "$*" >&2
  exit 1
}

installed() { [[ $(dpkg-query -W -f '${db:Status-Status}' "$1" 2>/dev/null) == installed ]]; }

# What the view of reports is bundled and tested with; isopach is built without. Node.js may have come from elsewhere, and
# Ubuntu has no package of Chromium: its tests are skipped there.
view_packages() {
  command -v node >/dev/null || echo nodejs
  command -v npm >/dev/null || echo npm
  command -v chromium >/dev/null || [[ -z $(apt-cache policy chromium | sed -n 's/^ *Candidate: //p' | grep -v '(none)') ]] ||
    echo chromium
}

missing_packages() {
  local package
  for package in "${packages[@]}"; do
    installed "$package" || echo "$package"
  done
  view_packages
}

have_laszip() { installed liblaszip-dev || [[ -e $laszip_prefix/include/laszip/laszip_api.h ]]; }

# Sets `root` to the words that run a command as root, or fails.
become_root() {
  if ((EUID == 0)); then
    root=(env)
  elif command -v sudo >/dev/null; then
    root=(sudo)
    [[ -t 0 ]] || root=(sudo -n)
  else
    return 1
  fi
  root+=(env DEBIAN_FRONTEND=noninteractive)
}

apt_install() {
  "${root[@]}" apt-get -q -y -o DPkg::Lock::Timeout=600 install --no-install-recommends "$@"
}

apt_update() {
  say "updating the package lists"
  "${root[@]}" apt-get -q -o DPkg::Lock::Timeout=600 update
}

apt_has_laszip() { [[ -n $(apt-cache policy liblaszip-dev | sed -n 's/^ *Candidate: //p' | grep -v '(none)') ]]; }

# apt with package lists of its own in $scratch: nothing of the machine's configuration changes.
apt_neighbour() {
  local tool=$1
  shift
  "$tool" -q -o Dir::Etc::SourceList="$scratch/sources.list" -o Dir::Etc::SourceParts=/dev/null \
    -o Dir::State::Lists="$scratch/lists" -o Dir::Cache="$scratch/cache" -o APT::Sandbox::User="$(id -un)" "$@"
}

# Downloads LASzip's packages to $scratch/deb from the mirror this machine already uses for its own release.
download_laszip() {
  local release mirror signed_by=
  release=$(sed -n 's/^VERSION_CODENAME=//p' /etc/os-release)
  [[ ! -e $keyring ]] || signed_by="[signed-by=$keyring] "
  scratch=$(mktemp -d)
  trap 'rm -rf "$scratch"' EXIT
  mkdir -p "$scratch/lists/partial" "$scratch/cache/archives/partial" "$scratch/deb"
  : >"$scratch/sources.list"
  # Third parties' archives may bear the same codename: the first one that has the package is the right one.
  while read -r mirror; do
    say "looking for LASzip in the suite $neighbour of the mirror in use"
    echo "deb $signed_by$mirror $neighbour main" >"$scratch/sources.list"
    if apt_neighbour apt-get update && (cd "$scratch/deb" && apt_neighbour apt-get download "${laszip_packages[@]}"); then
      return 0
    fi
  done < <(apt-get update --print-uris | sed -n "s|^'\(.*\)/dists/$release/\(In\)\?Release'.*|\1|p" | sort -u)
  return 1
}

install_laszip() {
  local as_root=$1
  if $as_root && apt_has_laszip; then
    say "installing liblaszip-dev"
    apt_install liblaszip-dev
    return
  fi
  download_laszip || fail "no LASzip: the suite $neighbour could not be read; install liblaszip-dev (or LASzip 3.4) by hand"
  if $as_root; then
    say "installing ${laszip_packages[*]} of $neighbour"
    apt_install "$scratch"/deb/*.deb
  else
    say "unpacking ${laszip_packages[*]} of $neighbour to ${laszip_prefix#"$project"/}"
    local package
    for package in "$scratch"/deb/*.deb; do dpkg-deb -x "$package" "$scratch/root"; done
    mkdir -p "${laszip_prefix%/*}"
    rm -rf "$laszip_prefix"
    mv "$scratch/root/usr" "$laszip_prefix"
  fi
}

check() {
  local missing
  missing=$(missing_packages)
  have_laszip || missing+=$'\n'liblaszip-dev
  if [[ -z $missing ]]; then
    say "nothing is missing"
    return 0
  fi
  say "missing:" $missing
  return 1
}

setup() {
  local missing as_root=true
  missing=$(missing_packages)
  if [[ -z $missing ]] && have_laszip; then
    say "nothing is missing"
    return
  fi
  become_root || as_root=false
  if $as_root; then
    apt_update
    if [[ -n $missing ]]; then
      say "installing:" $missing
      apt_install $missing
    fi
  fi
  have_laszip || install_laszip "$as_root"
  $as_root || [[ -z $missing ]] || fail "neither root nor sudo; ask for: apt-get install" $missing
  say "done"
}

command -v dpkg-query >/dev/null && command -v apt-get >/dev/null ||
  fail "this is not Debian or Ubuntu; the packages needed are: ${packages[*]} liblaszip-dev"
case ${1-} in
  "") setup ;;
  --check) check ;;
  --help | -h) sed -n '2,/^set /{/^set /d;s/^# \{0,1\}//;p;}' "$0" ;;
  *) fail "unknown option $1: use --check or --help" ;;
esac
