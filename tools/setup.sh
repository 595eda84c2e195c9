# What ./virtdrive and ./dev share: installing what is missing, and building a preset.
# Sourced by bash with the repository's root as working directory. Speaks on standard error.

readonly PACKAGES_RUN="ca-certificates ccache cmake g++ libboost-dev libcli11-dev libfmt-dev \
libmatio-dev libsundials-dev libyaml-cpp-dev ninja-build nlohmann-json3-dev"
readonly PACKAGES_TEST="libbenchmark-dev libeigen3-dev libgtest-dev mbpoll picocom python3 python3-can \
python3-jsonschema python3-junitparser python3-serial python3-yaml socat tmux"
readonly PACKAGES_CHECK="clang-19 clang-format-19 libclang-rt-19-dev llvm-19"

say() { printf '%s\n' "$*" >&2; }
die() {
  say "$0: $*"
  exit 2
}

missing_packages() {
  local name
  for name in "$@"; do
    dpkg-query -W -f='${db:Status-Status}\n' "$name" 2>/dev/null | grep -qx installed || printf '%s ' "$name"
  done
}

# install PACKAGE...: those that are not there yet, from Debian, without what is only recommended.
install() {
  if ! command -v dpkg-query >/dev/null; then
    say "This is not Debian: make sure that the equivalents of these packages are there: $*"
    return
  fi
  local missing as_root=""
  missing=$(missing_packages "$@")
  [ -n "$missing" ] || return 0
  if [ "$(id -u)" -ne 0 ]; then
    if ! command -v sudo >/dev/null || ! sudo -n true 2>/dev/null; then
      die "not installed: ${missing}
Install them as root, then start this again:
  apt-get install --no-install-recommends ${missing}"
    fi
    as_root="sudo -n"
  fi
  say "Missing packages: ${missing}"
  $as_root apt-get update -qq >&2
  # shellcheck disable=SC2086
  LC_ALL=C $as_root apt-get install --no-install-recommends --assume-no $missing 2>/dev/null |
    grep -E '^(Need to get|After this operation|[0-9]+ upgraded)' >&2 || true
  # shellcheck disable=SC2086
  DEBIAN_FRONTEND=noninteractive $as_root apt-get install -y -qq --no-install-recommends $missing \
    </dev/null >/dev/null || die "apt-get could not install: ${missing}"
}

# build PRESET TARGET...: configures at the first time, then builds what is not up to date. Two at once wait
# for each other.
build() {
  local preset=$1
  shift
  mkdir -p "build/$preset"
  (
    flock 9
    [ -f "build/$preset/build.ninja" ] || cmake --preset "$preset" "${CONFIGURE[@]}" >&2 ||
      exit 1
    ninja -C "build/$preset" "$@" >&2
  ) 9>"build/$preset/.lock" || die "the build failed (preset $preset)"
}
CONFIGURE=()
