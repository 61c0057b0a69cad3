# Who runs the command (sourced by docker/run): Docker, Podman or, as root on Debian, buildah; and its image.
#
# recipe_hash      what the image is made of, as a short name
# choose_engine    sets `engine` to the first that works, its image built; says why another was passed over
# shellcheck shell=bash disable=SC2154 # arguments, cache, checkout, container, image, snapshot, die, say: docker/run

engine=
silent=() # engines that are here and do not answer, with the reason

recipe_hash() {
    local files=(Dockerfile versions.txt check-versions install-stack leave-out)
    { cd "$checkout/docker" && cat "${files[@]}" && printf %s "$snapshot"; } | sha256sum | cut -c1-12
}

# Is it here, and does it answer?
answers() {
    local said
    command -v "$1" >/dev/null || return 1
    said=$(timeout 20 "$1" info 2>&1) && [[ $said != *'Cannot connect to'* ]] && return
    case ${said,,} in
    *'permission denied'*) silent+=("$1 is here, but you may not use it (permission denied; see \`$1 info\`)") ;;
    *) silent+=("$1 is here, but does not answer (see \`$1 info\`)") ;;
    esac
    return 1
}

ready() {
    case $engine in
    buildah) buildah inspect "$container" ;;
    *) "$engine" image inspect "$image" && [[ -e $cache/ran.$engine.${image#*:} ]] ;;
    esac >/dev/null 2>&1
}

build() {
    if [[ $engine == buildah ]]; then
        "$checkout/docker/buildah-image" "$image" "$container" "$snapshot"
        return
    fi
    if ! "$engine" image inspect "$image" >/dev/null 2>&1; then
        "$engine" build --tag "$image" --build-arg "SNAPSHOT=$snapshot" "$checkout/docker" || return
    fi
    "$engine" run --rm "$image" true || return # an engine may build and have no working runtime
    touch "$cache/ran.$engine.${image#*:}"
}

# Makes the image if it is not there. One at a time: the others wait.
prepare() {
    local locks=$cache log=$cache/build.$engine.log
    if [[ $engine == buildah ]]; then
        locks=/run/lock
        exec 7>"$locks/$container" && flock -s 7 # another recipe's build removes what nobody holds or has used lately
    fi
    ready && return
    exec 8>"$locks/graded-fretting-build"
    flock -n 8 || { say "waiting for another docker/run to build the image" && flock 8; }
    if ! ready; then
        say "building the image (about 4 minutes, see $log)"
        build 3>&2 >"$log" 2>&1 </dev/null || { exec 8>&- && return 1; }
        grep -o 'check-versions: .*\|install-stack: .*' "$log" >&2 || true
    fi
    exec 8>&-
}

# Remembers for a day who was passed over, so that not every run tries to build with it.
remember() {
    local name
    for name; do echo "it could not build or run the image on $(date '+%F %R')" >"$cache/passed-over.$name"; done
}

choose_engine() {
    local failed=() note
    for engine in docker podman; do
        answers "$engine" || continue
        note=$cache/passed-over.$engine
        if [[ $(find "$note" -mmin -1440 2>/dev/null) ]]; then
            say "not by $engine: $(<"$note"); it is tried again after a day, or when you delete $note"
        elif prepare; then
            remember "${failed[@]}"
            return
        else
            failed+=("$engine")
            say "not by $engine, which cannot build or run the image: $(tail -n 1 "$cache/build.$engine.log")"
        fi
    done
    engine=buildah
    if [[ $(id -u) != 0 ]] || ! command -v apt-get >/dev/null; then
        for note in "${silent[@]}"; do say "$note"; done
        die "needs FEniCSx 0.9, or a running Docker or Podman, or root on a Debian machine"
    fi
    # A script's background job ignores SIGINT; bash cannot undo that by itself, and an engine's client would.
    [[ $(trap -p INT) != *"''"* ]] || exec env --default-signal=INT "$checkout/docker/run" "${arguments[@]}"
    export BUILDAH_ISOLATION=chroot # what plain root can do
    export CONTAINERS_STORAGE_CONF=$checkout/docker/storage.conf
    if ! prepare; then
        tail -n 20 "$cache/build.buildah.log" >&2
        die "building the image failed, the whole log is $cache/build.buildah.log"
    fi
    remember "${failed[@]}"
}
