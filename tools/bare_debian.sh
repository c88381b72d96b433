#!/usr/bin/env bash
# Tries ./run and ./test where nothing is installed: a minimal Debian 12 tree, a copy of the sources, a chroot.
#
#   tools/bare_debian.sh [FOLDER]     FOLDER: where the trees are kept (default /var/tmp/orasp-bare)
#
# FOLDER/base is made once by debootstrap with this machine's own package sources; each trial starts from a fresh copy
# of it in FOLDER/trial. Needs root and debootstrap; runs in a mount namespace of its own, so nothing stays mounted.
set -euo pipefail

root=$(cd "$(dirname "${BASH_SOURCE[0]}")/.." && pwd -P)
folder=${1:-/var/tmp/orasp-bare}
suite=bookworm

die() {
  printf 'bare_debian: %s\n' "$*" >&2
  exit 1
}
((EUID == 0)) || die "must be run by root"
command -v debootstrap >/dev/null || die "debootstrap is missing: apt-get install debootstrap"
if [[ ${BARE_DEBIAN_UNSHARED:-} != 1 ]]; then
  mkdir -p "$folder"
  folder=$(cd "$folder" && pwd -P)
  BARE_DEBIAN_UNSHARED=1 exec unshare --mount --propagation private "$0" "$folder"
fi

# This machine's mirror of the suite, as apt itself understands its configuration.
# shellcheck disable=SC2016  # apt expands the names
mirror=$(apt-get indextargets --format '$(SITE) $(CODENAME) $(COMPONENT)' 'Created-By: Packages' |
  awk -v suite="$suite" '$2 == suite && $3 == "main" {print $1; exit}')
[[ $mirror ]] || die "no package source of $suite main is configured here"

if [[ ! -e $folder/base.done ]]; then
  printf '== a minimal %s from %s\n' "$suite" "$mirror"
  rm -rf --one-file-system "${folder:?}/base"
  debootstrap --variant=minbase "$suite" "$folder/base" "$mirror" >"$folder/debootstrap.log" 2>&1 ||
    die "debootstrap failed: see $folder/debootstrap.log"
  rm -rf "$folder/base/etc/apt"
  cp -a /etc/apt "$folder/base/etc/apt"
  touch "$folder/base.done"
fi

trial=$folder/trial
rm -rf --one-file-system "${trial:?}"
cp -a "$folder/base" "$trial"
cp -L /etc/resolv.conf /etc/hosts "$trial/etc/"
certificates=/etc/ssl/certs/ca-certificates.crt  # this machine's, for the npm registry
mkdir -p "$trial/etc/ssl/of-this-machine"
[[ ! -e $certificates ]] || cp -L "$certificates" "$trial/etc/ssl/of-this-machine/certificates.crt"
mkdir "$trial/orasp"
(cd "$root" && git ls-files -z --cached --others --exclude-standard |
  while IFS= read -r -d '' file; do [[ ! -e $file ]] || printf '%s\0' "$file"; done |
  tar --null --files-from=- -cf -) | tar -C "$trial/orasp" -xf -
mount -t proc proc "$trial/proc"
mount --rbind /dev "$trial/dev"

inside() {
  printf '\n== bare: %s\n' "$*"
  local start=$SECONDS
  env -i PATH=/usr/local/sbin:/usr/local/bin:/usr/sbin:/usr/bin:/sbin:/bin HOME=/root LC_ALL=C CI=true \
    NODE_EXTRA_CA_CERTS=/etc/ssl/of-this-machine/certificates.crt npm_config_cafile=/etc/ssl/of-this-machine/certificates.crt \
    ${http_proxy:+http_proxy="$http_proxy"} ${https_proxy:+https_proxy="$https_proxy"} \
    chroot "$trial" "$@" </dev/null
  printf '== %d s\n' $((SECONDS - start))
}
inside /orasp/run
inside /orasp/run solve lattice
inside /orasp/test
