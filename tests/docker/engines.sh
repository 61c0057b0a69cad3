#!/usr/bin/env bash
# tests/docker/engines.sh   which engine docker/run takes, with stand-ins for Docker and Podman
#
# A stand-in answers as it is told (FAKE_DOCKER, FAKE_PODMAN: forbidden, stopped, broken, lame, works); one
# that works runs the command on the host. No image is built. Ends with the number of failures.
set -uo pipefail
root=$(cd "$(dirname "${BASH_SOURCE[0]}")/../.." && pwd -P)
[[ ! ${GRADED_FRETTING_STACK-} ]] || { echo "only outside the stack" && exit 1; }
work=$(mktemp -d ~/engines.XXXXXX)
trap 'rm -rf "$work"' EXIT
export XDG_CACHE_HOME=$work/cache
cat >"$work/docker" <<'STAND_IN'
#!/usr/bin/env bash
name=${0##*/} state=FAKE_${0##*/} && state=${state^^} && state=${!state}
case $state.$1 in
forbidden.*) echo 'permission denied while trying to connect to the Docker daemon socket' >&2; exit 1 ;;
stopped.*) echo 'Cannot connect to the Docker daemon. Is the docker daemon running?' >&2; exit 1 ;;
broken.build) echo "runtime of $name not found" >&2; exit 125 ;;
*.info) echo rootless: true ;;
*.image) [[ -e $XDG_CACHE_HOME/$name.built ]] ;;
lame.run) echo "$name: no working runtime" >&2; exit 126 ;;
*.build) echo "$*" >"$XDG_CACHE_HOME/$name.built" ;;
works.run) while [[ $1 != graded-fretting:* ]]; do shift; done; shift; echo "by $name"; exec "$@" ;;
esac
STAND_IN
printf '#!/bin/sh\n[ "$*" = -u ] && echo 1000 || /usr/bin/id "$@"\n' >"$work/id" # root would go on with buildah
chmod +x "$work"/* && cp "$work/docker" "$work/podman"
failures=0

# expect NAME DOCKER PODMAN PATTERN: what docker/run says or does with engines in these states
expect() {
    local said
    said=$(PATH=$work:$PATH FAKE_DOCKER=$2 FAKE_PODMAN=$3 timeout 60 "$root/docker/run" echo done 2>&1)
    # shellcheck disable=SC2053 # a pattern
    if [[ $said == $4 ]]; then echo "ok    $1"; return; fi
    echo "FAIL  $1" && sed 's/^/      /' <<<"$said"
    failures=$((failures + 1))
}

expect "Docker is taken first" works works "*by docker"$'\n'done
expect "Podman is taken where Docker is stopped" stopped works "*by podman"$'\n'done
expect "no permission for Docker is told from" forbidden stopped \
    "docker/run: docker is here, but you may not use it (permission denied*podman is here*needs FEniCSx*"
expect "a stopped Docker" stopped stopped \
    "docker/run: docker is here, but does not answer*podman is here, but does not answer*needs FEniCSx*"
rm -f "$work/cache/docker.built"
expect "an engine that cannot build is passed over, and why" broken works \
    "*not by docker, which cannot build or run the image: runtime of docker not found*by podman"$'\n'done
expect "and not tried again at once" broken works "docker/run: not by docker: it could not build*by podman"$'\n'done
rm -f "$work"/cache/*.built "$work"/cache/graded-fretting/passed-over.*
expect "nor one that builds and cannot run" lame works \
    "*not by docker, which cannot build or run the image: docker: no working runtime*by podman"$'\n'done
rm -f "$work"/cache/*.built "$work"/cache/graded-fretting/*
export GRADED_FRETTING_SNAPSHOT=20260801T000000Z
expect "a dated archive is asked for" works works "*by docker"$'\n'done
grep -q -- "--build-arg SNAPSHOT=$GRADED_FRETTING_SNAPSHOT" "$work/cache/docker.built" || failures=$((failures + 1))
GRADED_FRETTING_SNAPSHOT=yesterday
expect "and refused where it is no date" works works "snapshot = yesterday: not a date like*"
echo "$failures failed"
exit "$failures"
